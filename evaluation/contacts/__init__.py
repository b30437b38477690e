"""Random single contacts: a finger that is pressed against a peg, with what is true about it, for estimators to be tried on."""
