"""Commands that look into scenarios, files and the installation, and simulate nothing."""
