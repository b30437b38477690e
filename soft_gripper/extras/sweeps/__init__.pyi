"""Many runs: their executor and tables, sweeps of a scenario, agreement of engines, and tuning of gains."""

from .axes import Range as Range
from .axes import Values as Values
from .axes import sweep_points as sweep_points
from .executor import open_executor as open_executor
from .measured_runs import run_and_measure as run_and_measure
from .sweep import run_sweep as run_sweep
from .tuning import gains_from_step_response as gains_from_step_response
from .tuning import step_response as step_response
from .tuning import tune as tune
