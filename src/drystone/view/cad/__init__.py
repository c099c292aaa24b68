"""Answers as files for CAD programs: Rhino 3dm, GLB."""
