"""Errors of estimators with bad sensors, wrong nominal models and other plants."""
