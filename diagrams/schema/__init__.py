"""What a scenario may say, and reading it."""
