"""What every module may use: array types, files written whole, units, errors, tables."""
