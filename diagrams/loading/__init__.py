"""Models from files: what is put right on the way into the plant."""
