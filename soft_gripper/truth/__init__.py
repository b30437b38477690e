"""What only a simulation knows, for estimates to be scored against."""
