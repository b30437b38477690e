"""Recordings of hardware: described by YAML, read into arrays."""
