"""Additions of this extra: a kind of documents, by a key that they have."""

DOCUMENTS = {"vary": "a study for `soft-gripper design`"}
