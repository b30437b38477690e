"""The shape of a finger: what an estimator takes and gives, and what follows."""
