"""Units in which hardware is recorded."""

LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}  # m
PRESSURE = {"Pa": 1.0, "hPa": 1e2, "mbar": 1e2, "kPa": 1e3, "bar": 1e5, "psi": 6894.757293168}  # Pa, NIST SP 811
TIME = {"s": 1.0, "ms": 1e-3}  # s
