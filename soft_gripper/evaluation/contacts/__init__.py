"""Random single contacts: a finger pressed against a peg, and what is true about it, for estimators to be tried on."""
