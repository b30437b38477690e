"""Sweeps: a scenario run with many changes, in one table."""
