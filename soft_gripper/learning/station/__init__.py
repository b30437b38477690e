"""A station with the ports `action` and `observation`."""
