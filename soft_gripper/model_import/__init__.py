"""Files that others made, URDF, SDFormat, MJCF and meshes, read into what Drake takes: one door, `read_model`."""
