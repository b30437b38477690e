"""Readings, pressure and base pose -> shape, load, contact."""
