"""LinkContact: with what force every link of a finger touches something; and what follows for the whole finger."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.geometry import GeometryId
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.signals import describe

TOUCH = 1e-3  # N; a link touches something where it is pressed harder
STRAIGHT = 0.1  # 1/m; a joint bent less, to a radius above 10 m, is straight


class LinkContact(LeafSystem):
    """Picks the contact forces on the links of one finger out of the plant's contact results.

    ::

                            +-------------+
        contact_results --> | LinkContact | ---> link_contact_force  (N + 1) N, from the base to the tip
                            +-------------+

    The force on a link is the sum of the magnitudes of all that touches it from outside, friction included.
    """

    def __init__(self, shapes: Sequence[Sequence[GeometryId]]):
        """`shapes` are the collision shapes of every link, from the base to the tip."""
        super().__init__()
        self._link_of = {shape: link for link, of_link in enumerate(shapes) for shape in of_link}
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        force = self.DeclareVectorOutputPort("link_contact_force", len(shapes), self._calc, {self._results.ticket()})
        describe(force, "N", link=range(len(shapes)))

    def _calc(self, context: Context, output: BasicVector) -> None:
        results, found = self._results.Eval(context), []
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            surface = info.contact_surface()
            found.append(((surface.id_M(), surface.id_N()), info.F_Ac_W().translational()))
        for i in range(results.num_point_pair_contacts()):
            point = results.point_pair_contact_info(i)
            found.append(((point.point_pair().id_A, point.point_pair().id_B), point.contact_force()))
        forces = np.zeros(output.size())
        for shapes, force in found:
            for shape in shapes:
                if shape in self._link_of:
                    forces[self._link_of[shape]] += np.linalg.norm(force)
        output.SetFromVector(forces)


def touches(force: Array) -> NDArray[np.bool_]:
    """Which links touch something, by the forces on them, (...) N."""
    return force > TOUCH


def contact_length(finger: Finger, touching: NDArray[np.bool_]) -> Array:
    """Length of finger that touches something, (..., N + 1) -> (...) m: the sum of the lengths of touching links."""
    length: Array = touching @ np.diff(finger.link_ends)
    return length


def changes_sign(finger: Finger, q: Array) -> NDArray[np.bool_]:
    """Whether the curvature of a finger changes its sign along it, joint angles (..., N) rad -> (...)."""
    curvature = q / finger.segment_length
    changes: NDArray[np.bool_] = (curvature.min(axis=-1) < -STRAIGHT) & (curvature.max(axis=-1) > STRAIGHT)
    return changes
