"""Changes of blocks and joints that keep every block closed."""
