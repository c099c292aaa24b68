"""Rest states with joints of different stiffness, such as shims make."""
