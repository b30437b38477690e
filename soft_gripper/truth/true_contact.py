"""TrueContact: what really presses on the fingers, for estimates to be compared with."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from soft_gripper.signals import XYZ, describe
from soft_gripper.truth.contact_patches import patches
from soft_gripper.truth.finger_contact import (
    NO_CONTACT,
    PLACES,
    TouchedLinks,
    contact_signals,
    contact_width,
    finger_contact,
)


class TrueContact(LeafSystem):
    """Sums up the plant's contact results for the fingers.

    ::

                            +-------------+ ---> {finger}.link_contact_force       (N + 1) N, friction included
                            |             | ---> {finger}.link_normal_force        (N + 1) N, positive inside
        contact_results --> |             | ---> {finger}.true_contact_force       (1) N, positive inside
                            | TrueContact | ---> {finger}.true_contact_total       (1) N, friction included
        body_poses -------> |             | ---> {finger}.true_contact_arc_length  (1) m
                            |             | ---> {finger}.normal_force             (1) N, on what is touched
                            |             | ---> {finger}.contact_center           (3) m, of that, in the world
                            +-------------+ ---> width                             (1) m, between what all touch

    Forces are those that the finger receives from outside. `true_contact_force` is the sum of `link_normal_force`: each
    across its link, in the bending plane, positive where it presses on the inner side, so that it opens the finger.
    `true_contact_total` is the sum of `link_contact_force`, magnitudes of all that touches a link. The arc length is
    that of the centre of pressure. `normal_force` goes by the surfaces that touch instead: the sum of what presses,
    along the normal of each. Without contact forces are 0 and places NaN; for the width see `contact_width`.
    """

    def __init__(self, fingers: Mapping[str, TouchedLinks]):
        """`fingers` by their names."""
        super().__init__()
        self._fingers = dict(fingers)
        self._shapes = frozenset(shape for finger in fingers.values() for shape in finger.link_of)
        self._links = [len(finger.bodies) for finger in fingers.values()]
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._collect)
        self._contacts = self.DeclareCacheEntry("contacts", producer, {self._results.ticket(), self._poses.ticket()})
        ticket = {self.cache_entry_ticket(self._contacts.cache_index())}
        self._untouched = [contact_signals(NO_CONTACT, links) for links in self._links]
        for i, name in enumerate(self._fingers):
            for signal, value in self._untouched[i].items():
                calc = partial(self._calc, i, signal)
                port = self.DeclareVectorOutputPort(f"{name}.{signal}", len(value), calc, ticket)
                describe(port, "m" if signal in PLACES else "N", **_axes(signal, len(value)))
        describe(self.DeclareVectorOutputPort("width", 1, self._calc_width, ticket), "m")

    def _collect(self, context: Context, value: AbstractValue) -> None:
        found = list(patches(self._results.Eval(context), self._shapes))
        if not found:
            value.set_value((self._untouched, float("nan")))
            return
        poses = self._poses.Eval(context)
        contacts = [finger_contact(finger, found, poses) for finger in self._fingers.values()]
        signals = [contact_signals(*each) for each in zip(contacts, self._links, strict=True)]
        value.set_value((signals, contact_width(contacts)))

    def _calc(self, finger: int, signal: str, context: Context, output: BasicVector) -> None:
        signals, _ = self._contacts.Eval(context)
        output.set_value(signals[finger][signal])

    def _calc_width(self, context: Context, output: BasicVector) -> None:
        _, width = self._contacts.Eval(context)
        output.SetAtIndex(0, width)


def _axes(signal: str, size: int) -> dict[str, Sequence[Any]]:
    """The axes of a signal with so many entries."""
    if size == 1:
        return {}
    return {"link": range(size)} if signal.startswith("link_") else {"xyz": XYZ}
