"""Base modules: array types, complete writing of files, units, errors, tables."""
