"""Views: Meshcat, replays, colours, block diagrams."""
