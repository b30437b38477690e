"""The whole evaluation: all runs side by side, their tables, figures and claims, and one report of them."""
