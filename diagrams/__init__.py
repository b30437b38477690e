"""The wiring: scenarios -> diagrams -> recordings."""
