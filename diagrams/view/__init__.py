"""What is seen: Meshcat, replays, colours, block diagrams."""
