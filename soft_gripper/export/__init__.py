"""Scenarios as files of other simulators."""
