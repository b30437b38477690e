"""Scores of one recorded run."""
