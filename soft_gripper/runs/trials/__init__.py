"""Pick and place over random objects, scored against ground truth."""
