"""How the estimators bear sensors with errors, wrong beliefs, and plants that are not as they believe."""
