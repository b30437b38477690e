"""Published recordings of hardware: fitted fingers, held-out recordings and claims."""
