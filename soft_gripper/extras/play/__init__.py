"""A station simulated in real time, commanded and watched in a browser."""
