"""The search for the best boundaries between sensor sections."""
