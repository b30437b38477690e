"""Commands that are given recordings: of simulated fingers, and of hardware."""
