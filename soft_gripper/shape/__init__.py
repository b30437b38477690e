"""Readings, pressure, base pose -> shape: the estimators, by one contract."""
