"""Lists our estimators by task and name, with the protocol of the benchmark."""

from studies.benchmark.benchmark_task import BenchmarkTask, Estimator
from studies.benchmark.measured_force import measured_force
from studies.benchmark.ours_recorded import (
    arm_tip,
    beam_load,
    beam_tip,
    segment_tip,
    tendons_tip,
    trunk_dc_shape,
    trunk_load,
    trunk_shape,
)
from studies.benchmark.ours_simulated import contact_force, contact_place, contact_tip, contact_transverse, grasp_shape

_SHAPE_ESTIMATORS = ("arcs", "gaussian", "contact")
_TIME_ESTIMATORS = ("arcs", "gaussian", "recursive")

_OUR_ESTIMATORS: dict[str, dict[str, Estimator]] = {
    "contact_tip": {name: contact_tip(name) for name in _SHAPE_ESTIMATORS},
    "contact_force": {"contact": contact_force},
    "contact_place": {"contact": contact_place},
    "contact_transverse": {"contact": contact_transverse},
    "grasp_shape": {"fitted": grasp_shape},
    "grasp_new": {"fitted": grasp_shape},
    "arm_tip": {name: arm_tip(name) for name in _TIME_ESTIMATORS},
    "beam_tip": {name: beam_tip(name) for name in _TIME_ESTIMATORS},
    "beam_load": {"fitted": beam_load},
    "segment_tip": {"fitted": segment_tip},
    "tendons_v4_tip": {"fitted": tendons_tip},
    "tendons_v6_tip": {"fitted": tendons_tip},
    "trunk_shape": {"fitted": trunk_shape},
    "trunk_load": {"fitted": trunk_load},
    "trunk_dc_shape": {"fitted": trunk_dc_shape},
}


def ours(task: BenchmarkTask) -> dict[str, Estimator]:
    """Our estimators of a task; `contact` for all tasks of measured forces."""
    return _OUR_ESTIMATORS.get(task.name, {"contact": measured_force})
