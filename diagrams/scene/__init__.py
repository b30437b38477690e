"""The plant: models in their places."""
