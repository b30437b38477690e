"""Every named signal against time."""
