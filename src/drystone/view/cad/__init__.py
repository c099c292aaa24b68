"""Answers as files for CAD programs: Rhino 3dm, GLB; :mod:`drystone.view.cad.save_cad`."""
