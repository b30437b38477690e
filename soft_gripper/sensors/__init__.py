"""Joint angles -> readings."""
