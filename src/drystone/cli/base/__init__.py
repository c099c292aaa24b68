"""What every command is made of: options in groups, an answer, output, progress."""
