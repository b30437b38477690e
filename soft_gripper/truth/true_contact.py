"""TrueContact: what really presses on the fingers, for estimates to be compared with."""

from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import Context

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.signals import XYZ
from soft_gripper.truth.contact_patches import patches
from soft_gripper.truth.finger_contact import (
    CONTACT_SIGNALS,
    PLACES,
    FingerContacts,
    TouchedLinks,
    contact_signals,
    contact_width,
    finger_contacts,
    links_by_shape,
    patch_table,
)


class TrueContact(ArrayBlock):
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
        self._links = links_by_shape(list(fingers.values()))
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self.show("patches", self._collect, {self._results.ticket(), self._poses.ticket()})
        self.derive("contacts", _of_sample, "patches", over_time=_of_samples)
        for number, (name, finger) in enumerate(fingers.items()):
            self._put_out_signals(number, name, len(finger.bodies))
        count = len(fingers)
        self.put_out("width", lambda contacts: contact_width([*map(contacts.of, range(count))]), "contacts", unit="m")

    def _put_out_signals(self, number: int, name: str, links: int) -> None:
        self.derive(name, lambda contacts: contact_signals(contacts.of(number), links), "contacts")
        sizes = {"link_contact_force": links, "link_normal_force": links, "contact_center": 3}
        for signal in CONTACT_SIGNALS:
            unit, axes = "m" if signal in PLACES else "N", _axes(signal, sizes.get(signal, 1))
            self.put_out(f"{name}.{signal}", itemgetter(signal), name, unit=unit, **axes)

    def _collect(self, context: Context) -> Array:
        found = list(patches(self._results.Eval(context), self._links))
        return patch_table(found, self._links, self._poses.Eval(context) if found else [])


def _of_sample(table: Array) -> FingerContacts:
    return finger_contacts(table, np.zeros(len(table), int), 1)


def _of_samples(tables: Sequence[Array]) -> FingerContacts:
    sample = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    return finger_contacts(np.concatenate(tables), sample, len(tables))


def _axes(signal: str, size: int) -> dict[str, Sequence[Any]]:
    """The axes of a signal with so many entries."""
    if size == 1:
        return {}
    return {"link": range(size)} if signal.startswith("link_") else {"xyz": XYZ}
