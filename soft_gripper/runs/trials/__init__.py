"""Pick and place over random objects, scored against the truth."""
