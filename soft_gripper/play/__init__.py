"""A station that is simulated in real time, commanded and watched in a browser."""
