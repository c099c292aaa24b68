"""Numerical back ends, independent of blocks and contacts."""
