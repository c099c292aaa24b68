"""Commands that answer: does it stand, by how much, and what happens."""
