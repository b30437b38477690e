"""What follows a set point."""
