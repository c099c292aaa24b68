"""What the contact search found, and what it left out and why."""
