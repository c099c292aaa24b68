"""The eight labelled designs of StableLego, as lists of bricks.

Source: Liu and others 2024, arXiv 2402.10711, and its data set (MIT), which says which stand. The
share is what each design needs of the largest pull of a contact point, by a linear program.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import drystone

G = 9.8
"""[m/s2] As in the data set."""


@dataclass(frozen=True)
class Design:
    """Bricks ``x y z size_x size_y rotation mass_g``, in studs and layers, and what is known."""

    lines: Sequence[str]
    stands: bool
    share: float


def _stair(count: int) -> list[str]:
    return [f"{2 * i} 21 {i} 4 2 0 2.16" for i in range(count)]


_GRAMS = {8: 3.03, 6: 2.28, 4: 1.57}
_AT = [(0, 0, 8), (6, 1, 4), (8, 2, 4), (10, 3, 8), (16, 2, 8), (22, 3, 6), (26, 2, 6),
       (30, 3, 6), (34, 2, 6), (38, 3, 6), (42, 2, 6), (44, 3, 4), (44, 4, 4)]  # fmt: skip
_STICK = [f"{x} 21 {z} {n} 1 0 {_GRAMS[n]}" for x, z, n in _AT]
_HEAVY = [*_STICK, "44 21 5 4 1 0 1.57"]

DESIGNS = {
    "stair-19": Design(_stair(19), True, 0.9007),
    "stair-20": Design(_stair(20), False, 1.0055),
    "stair-20-good": Design([*_stair(20), "4 21 0 1 2 0 0.81"], True, 0.9007),
    "stick-light": Design(_STICK, True, 0.9214),
    "stick-heavy": Design(_HEAVY, False, 1.0215),
    "stick-heavy-good": Design([*_HEAVY, "8 21 0 2 1 0 0.81"], True, 0.9341),
    "external-weight-good": Design([*_stair(3), "5 21 3 2 2 0 200"], True, 0.6413),
    "external-weight-fail": Design([*_stair(4), "7 21 4 2 2 0 200"], False, 1.1872),
}


def model_of_lines(lines: Sequence[str]) -> drystone.Model:
    """The model of a list of bricks under its weight."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "design.bricks"
        path.write_text("\n".join(lines) + "\n", "utf-8")
        return drystone.read(path, load=G / 9.81)


__all__ = ["DESIGNS", "Design", "G", "model_of_lines"]
