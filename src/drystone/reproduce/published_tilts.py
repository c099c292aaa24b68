"""Published tilt limits of small models (tables 6.1 to 6.4), and how to build them.

Source of the figures: Kao 2023, doctoral dissertation, ETH Zurich; Kao et al. 2022, "Coupled
Rigid-Block Analysis", Computer-Aided Design 146. Angles in degrees; 180 where it never fell.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

import numpy as np

from drystone import models
from drystone.assembly import Assembly
from drystone.base.display import OneLine

Axis = tuple[float, float, float]

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
XY30 = (1.7320508075688772, 1.0, 0.0)
XY, XNY = (1.0, 1.0, 0.0), (1.0, -1.0, 0.0)


@dataclass(frozen=True)
class Study(OneLine):
    """One tilt test.

    Attributes
    ----------
    model, axis_name
        For the table.
    build
    axis
        The assembly turns counter-clockwise about it.
    friction
    dem, cra, rbe : [degrees]
        Published: 3DEC, CRA and RBE; None where not published.
    tolerance : [degrees]
        Half the last digit of the published 3DEC figure, and some: 0.5 or 1.5.
    sofistik : [degrees]
        Published for the curved joints (table 6.4).
    published_axis
        Name of the axis in the source, where ours is another.
    """

    model: str
    axis_name: str
    build: Callable[[], Assembly] = field(repr=False)
    axis: Axis
    friction: float
    dem: float
    cra: float
    rbe: float | None
    tolerance: float = 0.5
    sofistik: float | None = None
    published_axis: str = ""

    @property
    def axis_label(self) -> str:
        """Our name of the axis, with that of the source where it differs."""
        published = self.published_axis.split(",")[0]
        ours = "-x" if self.axis[0] == -1.0 else self.axis_name
        return f"{ours} (source: {published})" if published else ours

    @property
    def key(self) -> str:
        """Name of the study."""
        return f"{self.model} {self.axis_name} mu {self.friction:.2f}"


WEDGES: dict[Literal["a", "b", "c", "d"], tuple[tuple[float, ...], ...]] = {
    "a": ((21.8, 21.8, 25.0, 59.2, 59.2, 180.0), (71.3, 71.3, 71.3, 100.0, 100.0, 180.0),
          (24.8, 24.7, 28.0, 62.7, 62.9, 180.0)),
    "b": ((21.8, 21.8, 25.0, 58.7, 58.5, 180.0), (67.4, 67.4, 67.4, 109.1, 109.1, 180.0),
          (24.8, 24.7, 28.0, 63.1, 62.0, 180.0)),
    "c": ((13.0, 13.0, 13.0, 44.1, 44.1, 47.0), (41.3, 41.3, 41.3, 64.5, 64.4, 65.7),
          (14.9, 14.9, 15.0, 48.1, 40.2, 51.0)),
    "d": ((13.0, 13.0, 13.0, 44.1, 44.1, 50.0), (41.3, 41.3, 41.3, 70.0, 70.0, 70.0),
          (14.9, 14.9, 15.0, 49.0, 48.5, 54.0)),
}  # fmt: skip
"""Per axis x, y, xy30: 3DEC, CRA, RBE at mu 0.20, then at mu 0.84."""


def studies() -> list[Study]:
    """All published tilt tests, in the order of the dissertation."""
    found: list[Study] = []
    build: Callable[[], Assembly]
    dem: float
    cra: float
    rbe: float
    sofistik: float
    for kind, rows in WEDGES.items():
        for (name, axis), row in zip((("x", X), ("y", Y), ("xy30", XY30)), rows, strict=True):
            for friction, published in ((0.20, row[:3]), (0.84, row[3:])):
                build = partial(models.wedge, kind)
                dem, cra, rbe = published
                found.append(Study(f"type-{kind}", name, build, axis, friction, dem, cra, rbe))
    for mu, dem, cra in ((0.84, 40, 40), (0.10, 5, 5)):
        build = partial(models.concave, "short")
        found.append(
            Study("concave-short", "y", build, Y, mu, dem, cra, None, 1.5, published_axis="x")
        )
    for mu, dem, cra in ((0.84, 56, 54), (0.10, 10, 9)):
        build = partial(models.concave, "long")
        # published as "xy", but the figures are those of the tilt about y: the plank slides out at
        # tan(tilt) = mu (1 + 2 c / d), its centre c beyond the slab's edge and hooked d behind it
        found.append(
            Study("concave-long", "y", build, Y, mu, dem, cra, None, 1.5, published_axis="xy")
        )
    for name, axis, dem, cra, rbe, sofistik in (
        ("y", Y, 8, 8, 8, 8),
        ("-y", (0.0, -1.0, 0.0), 53, 53, 53, 53),
        ("x", X, 24, 24, 26, 24),
        ("xy", XY, 11, 12, 12, 12),
        ("xny", XNY, 46, 47, 48, 47),
    ):
        build = models.curve_three_blocks
        found.append(Study("curve-3-blocks", name, build, axis, 0.84, dem, cra, rbe, 1.5, sofistik))
    heights: tuple[tuple[Literal["short", "tall"], Sequence[tuple[float, float, float]]], ...] = (
        ("short", ((72, 70, 70), (68, 69, 64), (80, 79, 79))),
        ("tall", ((41, 40, 38), (39, 39, 38), (59, 51, 58))),
    )
    for height, angles in heights:
        for (name, axis), (dem, cra, sofistik) in zip(
            (("x", (-1.0, 0.0, 0.0)), ("xy", XY), ("xny", XNY)), angles, strict=True
        ):
            build = partial(models.cube_curve, height)
            model = f"cube-curve-{height}"
            turned = "x, which runs along -x of the files" if name == "x" else ""
            found.append(
                Study(model, name, build, axis, 0.84, dem, cra, 180.0, 1.5, sofistik, turned)
            )
    for angle, tilt in ((43.0, 8.2), (21.8, 3.0)):
        mu = float(np.tan(np.deg2rad(angle)))
        found.append(Study("arch", "y", models.arch, Y, mu, tilt, tilt, tilt))
    return found
