"""A scene in a browser, alone or with plots, sliders and buttons around it."""
