"""Replays recorded hardware readings through the estimation blocks."""
