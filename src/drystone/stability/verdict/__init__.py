"""The verdict of a check: the order of its tests, and each test."""
