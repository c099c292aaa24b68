"""How pictures look: colours, presets, edges that are drawn."""
