"""Sweeps: a scenario run with many variations, in one table."""
