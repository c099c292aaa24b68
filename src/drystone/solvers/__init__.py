"""Numerical back ends: numbers in, numbers out. They know no blocks."""
