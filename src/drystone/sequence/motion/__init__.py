"""How a block moves: directions and turns that its joints leave free, and finite ways out."""
