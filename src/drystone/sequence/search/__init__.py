"""Orders of assembly: the search through stages, and what it must respect."""
