"""Schedules and files for fabrication."""
