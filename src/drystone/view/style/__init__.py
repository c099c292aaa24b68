"""The style of pictures: colours, presets, edges that are drawn."""
