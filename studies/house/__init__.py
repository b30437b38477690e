"""The code itself: its size, its words, and its numbers before and after a change."""
