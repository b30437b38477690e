"""What was identified and replayed on real hardware, in one go, and what of it has to hold."""
