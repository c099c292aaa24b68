"""From blocks and contacts to numerical problems, and back."""
