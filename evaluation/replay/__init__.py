"""Estimators on recorded readings of hardware."""
