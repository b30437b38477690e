"""The forms of model files: each module reads one, by its `FORM`. Another form is another module."""
