"""Rest states on contact springs."""
