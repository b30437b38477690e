"""Recordings as MCAP files, for Foxglove."""
