"""An hour of grasping with sensors that drift, under policies of zeroing them."""
