"""What a finger is, and the chain of links, springs and pressures that stands for it."""
