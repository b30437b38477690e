"""Random single contacts: a finger pressed against a peg, with ground truth, as a test for estimators."""
