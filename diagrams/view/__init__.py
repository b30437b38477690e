"""Views: Meshcat, animations, colours, block diagrams."""
