"""Reads others' files, URDF, SDFormat, MJCF and meshes, for Drake: `read_model` is the one entry."""
