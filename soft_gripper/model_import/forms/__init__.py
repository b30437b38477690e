"""The forms of model files: each module has one, as its `FORM`."""
