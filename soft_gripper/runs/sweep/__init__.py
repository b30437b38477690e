"""Sweeps: a scenario run with many values of its fields, in one table."""
