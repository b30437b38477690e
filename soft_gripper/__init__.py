"""Soft, sensing grippers as blocks and wires in Drake. Start with README.md and notebooks/."""
