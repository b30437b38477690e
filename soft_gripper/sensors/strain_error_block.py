"""StrainErrorBlock: ideal readings of strain sensors -> those of sensors as they are."""

from dataclasses import dataclass

from soft_gripper.arrays import Array
from soft_gripper.sensors import strain_errors
from soft_gripper.sensors.calibrated_response import CalibratedResponse
from soft_gripper.sensors.error_block import ErrorBlock
from soft_gripper.sensors.response_curve import ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors
from soft_gripper.signals import describe


@dataclass(frozen=True)
class _ReadingErrors:
    """Errors of the extension ratio, between readings before and after."""

    errors: StrainErrors
    response: ResponseCurve | CalibratedResponse
    period: float
    draws = (strain_errors.RUN_DRAWS, strain_errors.SAMPLE_DRAWS)

    def begin(self, draws: Array) -> Array:
        return strain_errors.stacked(strain_errors.begin(self.errors, draws))

    def step(self, memory: Array, ideal: Array, draws: Array) -> tuple[Array, Array]:
        ratio = self.response.ratio(ideal)
        before = strain_errors.unstacked(memory)
        after, disturbed = strain_errors.step(self.errors, before, ratio, draws, self.period)
        return strain_errors.stacked(after), self.response.reading(disturbed)


class StrainErrorBlock(ErrorBlock):
    """Disturbs the readings of the strain sensors of one finger; see `ErrorBlock`.

    ::

        ideal_strain (paths * S) ------> +------------------+
                                         | StrainErrorBlock | ---> strain (paths * S) readings
        standard_normal (7 paths * S) -> +------------------+
    """

    def __init__(self, layout: SensorLayout, errors: StrainErrors, period: float):
        """Sensors of the given layout, sampled every `period` s."""
        model = _ReadingErrors(errors, layout.response, period)
        super().__init__(model, layout.readings, period, "ideal_strain", "strain")
        describe(self.GetOutputPort("strain"), "1", path=layout.path_names, section=range(layout.sections))
