"""A vault held by a wall on three sides, of which plans are compared."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.shells import Edge, Layout, Patch, Shape, ShellBody, Side, build_shell

NICHE = Layout(courses=5, blocks=7), ShellBody(thickness=0.35)
"""Courses and blocks of the vault, and their thickness."""


def niche_shape() -> Shape:
    """A quarter of a sphere, held by a wall on three sides, open at the top."""
    top, radius = math.radians(72.0), 3.0

    def point(u: Floats, v: Floats) -> Floats:
        latitude, longitude = top * u, np.pi * (v - 0.5)
        ring = radius * np.cos(latitude)
        return np.stack(
            [ring * np.cos(longitude), ring * np.sin(longitude), radius * np.sin(latitude)],
            axis=-1,
        )

    supports = (Edge(0, Side.BOTTOM), Edge(0, Side.LEFT), Edge(0, Side.RIGHT))
    return Shape((Patch(point, name="niche"),), supports=supports, name="niche")


def niche(wedge: float) -> Assembly:
    """A vault of 37 voussoirs in five courses, held by a wall on three sides, open at the top."""
    layout, body = NICHE
    return build_shell(niche_shape(), replace(layout, wedge=wedge), body).assembly
