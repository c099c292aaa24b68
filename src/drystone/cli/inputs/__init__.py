"""Options that several commands share, and the model that they define."""
