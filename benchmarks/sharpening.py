"""Thin arches that stand with wedges: ``python -m benchmarks.sharpening``.

Prints a table. Give numbers of voussoirs to take these only.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Sequence

import numpy as np

from drystone import Model, check
from drystone.design import DesignMargin, SharpenOptions, sharpen
from drystone.design.wedges.plane_joints import PlaneJoints
from drystone.models import arch
from drystone.stability import CheckOptions

HEAD = (
    "| voussoirs | thickness / radius | friction | rounds | wedges | sharpest | sum | needed | "
    "CPU s |\n|---|---|---|---|---|---|---|---|---|\n"
)
VOUSSOIRS, RATIOS, FRICTIONS = (15, 31), (0.04, 0.06), (0.6, 0.7, 0.84)


def row(voussoirs: int, ratio: float, friction: float) -> str:
    """One arch sharpened, and how many of its wedges are needed."""
    model = Model.of(arch(ratio, voussoirs), friction=friction)
    began = time.process_time()
    found = sharpen(model)
    spent = time.process_time() - began
    needed = 0
    joints, close = PlaneJoints.of(model), SharpenOptions().close
    for k in np.flatnonzero(found.sharpness):
        less = np.array(found.sharpness)
        less[k] = max(less[k] - close, 0.0)
        result = check(joints.wedged(less), options=CheckOptions(settle=False))
        needed += not DesignMargin().meets(result)
    angle = found.sharpness
    state = f"{len(found.joints)} of {len(angle)}" if found.stands else "falls"
    return (
        f"| {voussoirs} | {ratio:g} | {friction:g} | {found.rounds} | {state} | "
        f"{angle.max():.1f} | {angle.sum():.0f} | {needed} | {spent:.0f} |\n"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the rows that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("voussoirs", type=int, nargs="*")
    chosen = parser.parse_args(arguments).voussoirs
    print(HEAD, end="")
    for case in itertools.product(chosen or VOUSSOIRS, RATIOS, FRICTIONS):
        print(row(*case), end="", flush=True)


if __name__ == "__main__":
    main()
