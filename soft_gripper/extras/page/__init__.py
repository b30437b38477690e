"""The live page: plots, sliders and buttons around the scene, in a browser."""
