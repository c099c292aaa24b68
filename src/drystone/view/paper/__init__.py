"""Scenes on paper: static figures, reports, instructions."""
