"""What the contact search found, what it left out, and why."""
