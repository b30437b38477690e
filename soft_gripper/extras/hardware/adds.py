"""Additions of this extra: kinds of documents, by a key that they have."""

DOCUMENTS = dict.fromkeys(("source", "markers"), "a description of a bench or a recording, for --bench or --as")
