"""Recordings: every named signal over time."""
