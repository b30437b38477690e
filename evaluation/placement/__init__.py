"""Where sections of sensors best end: placements tried on recorded motions, with errors of sensors and belief."""
