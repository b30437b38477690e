"""Where the sections of the sensors best end."""
