"""Recognition of the shape that is held: random grasps, training and test."""
