"""ContactDetector: detects whether, and since when, a finger touches something.

Contact is detected from the section at the base, where the lever is longest.
"""

from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.steps import TIME

THRESHOLD = 2.5e-3  # N m
_RELEASE_RATIO = 0.5  # of the threshold, below which contact ends


class Touch(NamedTuple):
    """Result of a sample, (...) each."""

    residual: Array  # N m
    contact: Array  # 0 or 1
    since: Array  # s, NaN before the first contact


class ContactDetector(ArrayBlock):
    """Detects from the external torque of one finger whether it touches anything, also while an arm moves it.

    ::

        external_torque (N) N m ----> +-----------------+ ---> contact           (1) 0 or 1
                                      | ContactDetector | ---> contact_residual  (1) N m, mean over the first joints
        torque_tolerance (N) N m ---> +-----------------+ ---> contact_time      (1) s, last beginning of a contact

    The residual is the mean torque on the joints of the section at the base, where the lever of a contact is longest,
    negative where contact holds the finger open. Contact begins when the residual exceeds the threshold by more
    than the tolerance, and ends when residual and tolerance together are within half of it: the tolerance, by which
    inertia and steps of the pressure may be misjudged, counts against every change. `contact_time` is NaN before any.

    Give it the outputs of a ForceEstimator that is sampled every `period` s. While its torque is not finite, contact
    holds its value. The threshold is for samples every 10 ms and for fingers like the shipped ones, with two sections
    or more; docs/manipulation.md has what was measured with it.
    """

    def __init__(self, joints: int, base_joints: int, period: float, threshold: float = THRESHOLD):
        """`base_joints` of the `joints` of the finger lie in the section at the base; `threshold` in N m."""
        super().__init__(period)
        self._base_joints, self._threshold = base_joints, threshold
        self.take("external_torque", joints)
        self.take("torque_tolerance", joints)
        self.sample("now", TIME)
        sources = "now", "external_torque", "torque_tolerance"
        self.remember(
            *("touch", self._touch, *sources),
            begin=np.array([0.0, np.nan]),
            keep=lambda touch: np.stack(touch[1:], axis=-1),
            over_time=self._touches,
        )
        self.put_out("contact", attrgetter("contact"), "touch", meanings=("no contact", "contact"))
        self.put_out("contact_residual", attrgetter("residual"), "touch", unit="N m")
        self.put_out("contact_time", attrgetter("since"), "touch", unit="s")

    def _touch(self, memory: Array, time: Array, torque: Array, tolerance: Array) -> Touch:
        """Touch at a sample, after contact and since of the sample before, (..., 2)."""
        contact, since = memory[..., 0], memory[..., 1]
        residual, is_above, is_below = self._compare(torque, tolerance)
        touches = np.where(is_above, 1.0, np.where(is_below, 0.0, contact))
        return Touch(residual, touches, np.where(is_above & (contact == 0), time[..., 0], since))

    def _touches(self, time: Array, torque: Array, tolerance: Array) -> Touch:
        """Touches at all samples of a recording, (T) each; the first is not remembered."""
        residual, is_above, is_below = self._compare(torque, tolerance)
        first = self._touch(np.array([0.0, np.nan]), time[0], torque[0], tolerance[0])
        samples = np.arange(len(residual))
        last_decision = np.maximum.accumulate(np.where(is_above | is_below, samples, 0))
        touches = is_above[last_decision] & (last_decision > 0)
        begins = touches[1:] & ~touches[:-1]
        last = np.maximum.accumulate(np.where(begins, samples[1:], 0))
        since = np.where(last > 0, time[last, 0], np.nan)
        return Touch(residual, np.append(first.contact, touches[1:]), np.append(first.since, since))

    def _compare(self, torque: Array, tolerance: Array) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """Residuals, (...), and two masks: certainly above the threshold, and low enough to end contact."""
        n = self._base_joints
        residual, allowed = torque[..., :n].sum(axis=-1) / n, tolerance[..., :n].sum(axis=-1) / n
        is_above = np.abs(residual) - allowed > self._threshold
        return residual, is_above, np.abs(residual) + allowed < _RELEASE_RATIO * self._threshold
