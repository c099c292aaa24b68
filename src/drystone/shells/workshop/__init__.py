"""What making the blocks needs: schedules and files."""
