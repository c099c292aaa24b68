"""Thin arches that stand with wedges: ``python -m benchmarks.sharpening``.

Prints a table. Give numbers of voussoirs, ratios or friction coefficients to take these only.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from drystone import Model, check, read, write
from drystone.design import DesignMargin, SharpenOptions, sharpen
from drystone.design.sharpening import PlaneJoints
from drystone.models import arch

HEAD = (
    "| voussoirs | thickness / radius | friction | rounds | wedges | sharpest | sum | needed | "
    "its file | CPU s |\n|---|---|---|---|---|---|---|---|---|---|\n"
)
VOUSSOIRS, RATIOS, FRICTIONS = (15, 31), (0.04, 0.06), (0.6, 0.7, 0.84)


def row(voussoirs: int, ratio: float, friction: float, models: Path | None = None) -> str:
    """One arch sharpened, how many of its wedges are needed, and the check of its file."""
    model = Model.of(arch(ratio, voussoirs), friction=friction)
    began = time.process_time()
    found = sharpen(model)
    spent = time.process_time() - began
    with TemporaryDirectory() as folder:
        path = (models or Path(folder)) / f"arch-{voussoirs}-{ratio:g}-{friction:g}.json"
        write(found.model, path)
        again = check(read(path)).verdict.value
    needed = 0
    joints, close = PlaneJoints.of(model), SharpenOptions().close
    for k in np.flatnonzero(found.x):
        falls = True
        for value in (max(found.x[k] - close, 0.0), 0.0):
            less = np.array(found.x)
            less[k] = value
            result = check(joints.wedged(less))
            falls &= not DesignMargin().meets(result)
        needed += falls
    angle = found.x
    state = f"{len(found.changes)} of {len(angle)}" if found.stands else "falls"
    return (
        f"| {voussoirs} | {ratio:g} | {friction:g} | {found.rounds} | {state} | "
        f"{angle.max():.1f} | {angle.sum():.0f} | {needed} | {again} | {spent:.0f} |\n"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the rows that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("voussoirs", type=int, nargs="*")
    parser.add_argument("--ratio", type=float, action="append", help="thickness / radius")
    parser.add_argument("--friction", type=float, action="append")
    parser.add_argument("--models", type=Path, help="folder for the models that stand")
    asked = parser.parse_args(arguments)
    print(HEAD, end="", flush=True)
    cases = itertools.product(
        asked.voussoirs or VOUSSOIRS, asked.ratio or RATIOS, asked.friction or FRICTIONS
    )
    for case in cases:
        print(row(*case, asked.models), end="", flush=True)


if __name__ == "__main__":
    main()
