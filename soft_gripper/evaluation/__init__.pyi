"""Evaluation of recordings: averages over steady states, tables, figures, and the claims of the paper."""

from .contacts.dataset import Contacts as Contacts
from .contacts.dataset import load_contacts as load_contacts
from .pid_regimes import regime_scenarios as regime_scenarios
from .pid_regimes import regimes_figure as regimes_figure
