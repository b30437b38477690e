"""What an environment file may say, and reading it."""
