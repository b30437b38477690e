"""Recorded readings of hardware through the blocks of the estimation."""
