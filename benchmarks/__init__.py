"""Measurements and validation that anyone can run; each module is started with ``python -m``."""
