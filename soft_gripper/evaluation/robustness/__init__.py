"""Robustness of the estimators to sensor errors, wrong nominal models and different plants."""
