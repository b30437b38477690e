"""Evaluation of recordings: averages over steady states, tables, figures, and the claims of the paper."""

from .pid_regimes import regime_scenarios as regime_scenarios
from .pid_regimes import regimes_figure as regimes_figure
