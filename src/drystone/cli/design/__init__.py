"""Commands that change a design or plan its assembly."""
