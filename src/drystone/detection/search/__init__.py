"""Which faces of blocks touch, and where."""
