"""Fingers identified from recordings of hardware: parameters fitted by simulation."""
