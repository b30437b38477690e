"""Config, apply: each part of a scenario added to a diagram."""
