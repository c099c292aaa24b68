"""Scenes on a page: one HTML file, and its frame in a notebook."""
