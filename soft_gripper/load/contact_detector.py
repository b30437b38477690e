"""ContactDetector: detects whether, and since when, a finger touches something.

Contact is detected from the section at the base, where the lever is longest.
"""

from operator import attrgetter
from typing import NamedTuple

import numpy as np

from soft_gripper.array_block import TIME, ArrayBlock
from soft_gripper.arrays import Array

THRESHOLD = 2.5e-3  # N m
_RELEASE = 0.5  # of the threshold, below which contact ends


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
        """`joints` of the finger, of which `base_joints` lie in the section at the base; `threshold` in N m."""
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

    def _touch(self, before: Array, now: Array, torque: Array, tolerance: Array) -> Touch:
        """One sample, after contact and since of the sample before, (..., 2)."""
        contact, since = before[..., 0], before[..., 1]
        n = self._base_joints
        residual, allowed = torque[..., :n].sum(axis=-1) / n, tolerance[..., :n].sum(axis=-1) / n
        begins = (contact == 0) & (np.abs(residual) - allowed > self._threshold)
        ends = ~begins & (np.abs(residual) + allowed < _RELEASE * self._threshold)
        contact = np.where(begins, 1.0, np.where(ends, 0.0, contact))
        return Touch(residual, contact, np.where(begins, now[..., 0], since))

    def _touches(self, *samples: Array) -> Touch:
        """All samples of a recording, (T,) each; the first is not remembered."""
        found: list[Touch] = []
        before = begin = np.array([0.0, np.nan])
        for sample in zip(*samples, strict=True):
            before = np.stack(found[-1][1:], axis=-1) if len(found) > 1 else begin
            found.append(self._touch(before, *sample))
        return Touch(*np.moveaxis(np.array(found), -1, 0))
