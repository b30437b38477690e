"""What agents are rewarded for."""
