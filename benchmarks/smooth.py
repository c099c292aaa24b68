"""Whether neighbouring models cost alike: ``python -m benchmarks.smooth [--only NAME]``.

Rows of walls, arches and domes. In each row the next model is a little larger, thicker, rougher or
more tilted. The steps of a check are those that its result tells, ``n`` marks what does not stand.
Neighbours of which one takes more than 1.5 times the steps of the other are told below.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from benchmarks.workloads import Axis, X, Y
from drystone import Assembly, LoadCase, Model, check, models

MOST = 1.5
"""Ratio of steps above which a pair is told."""

Row = tuple[str, list[tuple[float, Callable[[], Model]]]]
"""Its name, and the value and the model of each neighbour."""


def _model(build: Callable[[], Assembly], axis: Axis, friction: float, tilt: float) -> Model:
    assembly = build()
    return Model.of(assembly, friction=friction, load=LoadCase.tilt(assembly, axis, tilt))


def _sizes(
    name: str, make: Callable[..., Assembly], sizes: Sequence[float], mu: float, tilt: float = 0.0
) -> Row:
    """By a size that ``make`` takes."""
    return name, [(one, partial(_model, partial(make, one), Y, mu, tilt)) for one in sizes]


def _tilts(name: str, build: Callable[[], Assembly], mu: float, tilts: Sequence[float]) -> Row:
    return f"{name} by tilt", [(one, partial(_model, build, Y, mu, one)) for one in tilts]


def _frictions(name: str, build: Callable[[], Assembly], span: Sequence[float], tilt: float) -> Row:
    values = np.geomspace(*span, 16).tolist()
    return f"{name} by friction", [(mu, partial(_model, build, Y, mu, tilt)) for mu in values]


def _square(count: int) -> Assembly:
    return models.wall(count, count)


def _rings(count: int) -> Assembly:
    return models.dome(slices=20, rings=count)


def _arch(count: int) -> Assembly:
    return models.arch(0.15, count)


def rows() -> list[Row]:
    """About 220 models."""
    wall, arch = partial(models.wall, 12, 12), partial(models.arch, 0.15, 20)
    dome = partial(models.dome, slices=20, rings=8, bonded=True)
    sizes, counts, rings = range(6, 22), range(10, 40), range(4, 14)
    leans = [(x, partial(_model, wall, X, 0.6, x)) for x in np.arange(0.0, 9.0, 0.5).tolist()]
    return [
        _sizes("wall n x n", _square, sizes, 0.6),
        _sizes("wall n x n, 8 deg", _square, sizes, 0.6, 8.0),
        ("wall across", leans),
        _tilts("wall", wall, 0.6, np.arange(0.0, 30.0, 2.0).tolist()),
        _frictions("wall", wall, (1.0, 0.2), 8.0),
        _sizes("arch of n", _arch, counts, 0.9),
        _sizes("arch of n, 5 deg", _arch, counts, 0.9, 5.0),
        _sizes("arch by thickness", models.arch, np.arange(0.11, 0.21, 0.005).tolist(), 0.9),
        _tilts("arch", arch, 0.9, np.arange(0.0, 12.0, 0.5).tolist()),
        _frictions("arch", arch, (1.2, 0.3), 0.0),
        _sizes("dome of n rings", _rings, rings, 0.84),
        _sizes("dome of n rings, 20 deg", _rings, rings, 0.84, 20.0),
        _tilts("dome", dome, 0.84, np.arange(0.0, 46.0, 3.0).tolist()),
        _frictions("dome", dome, (1.0, 0.3), 0.0),
    ]


def main() -> None:
    """A line for each row, and below it the pairs of which one takes much longer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="rows whose name begins so")
    given = parser.parse_args()
    pairs = rough = 0
    for name, row in rows():
        if not name.startswith(given.only):
            continue
        found = [(value, check(build())) for value, build in row]
        print(
            f"{name:24}", *(f"{r.iterations}{'n' * (not r.stable)}" for _, r in found), flush=True
        )
        for (low, one), (high, two) in pairwise(found):
            least, most = sorted((one.iterations, two.iterations))
            if one.verdict is two.verdict:
                pairs, rough = pairs + 1, rough + (most > MOST * least)
            if most > MOST * least:
                word = "" if one.verdict is two.verdict else f" {one.verdict} {two.verdict}"
                print(f"    {low:.4g} to {high:.4g}: {most / least:.2f}{word}; {two.message}")
    print(f"{rough} of {pairs} pairs with the same verdict differ by more than {MOST}")


if __name__ == "__main__":
    main()
