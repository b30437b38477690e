"""Adds each part of a scenario to a diagram, from its config."""
