"""The number of interfaces as a function of the gap tolerance, and its plateau."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints, frozen, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.detection.find import find_contacts
from drystone.detection.tolerances import DetectionOptions

FINEST, COARSEST = 1e-6, 0.1
"""Range of gaps in a sweep. Chosen: from the rounding of six-digit files to a tenth of a block."""


@dataclass(frozen=True)
class GapSweep(OneLine):
    """Number of contacts as a function of the gap tolerance.

    Attributes
    ----------
    gap : (s,) ascending, relative to the block size
    interfaces, pairs, isolated : (s,)
        Interfaces, pairs of blocks that touch, and blocks that touch nothing.
    """

    gap: Floats
    interfaces: Ints
    pairs: Ints
    isolated: Ints

    @property
    def plateau(self) -> tuple[float, float]:
        """The widest range of gaps, in ratio, over which the same number of pairs touch."""
        best, found = -1.0, (float(self.gap[0]), float(self.gap[0]))
        first = 0
        for i in range(1, len(self.gap) + 1):
            if i < len(self.gap) and self.pairs[i] == self.pairs[first]:
                continue
            width = float(np.log(self.gap[i - 1] / self.gap[first]))
            if self.pairs[first] > 0 and width > best:
                best, found = width, (float(self.gap[first]), float(self.gap[i - 1]))
            first = i
        return found

    @property
    def chosen(self) -> float:
        """A gap in the middle of the plateau, in ratio."""
        low, high = self.plateau
        return float(np.sqrt(low * high))

    def summary(self) -> list[str]:
        """A table, a line per gap."""
        low, high = self.plateau
        lines = ["gap        interfaces  pairs  isolated"]
        lines += [
            f"{gap:<10.3g} {m:>10,} {p:>6,} {i:>9,}{'  plateau' if low <= gap <= high else ''}"
            for gap, m, p, i in zip(
                self.gap, self.interfaces, self.pairs, self.isolated, strict=True
            )
        ]
        return [*lines, f"plateau from {low:.2g} to {high:.2g}; its middle is {self.chosen:.2g}"]

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain lists and numbers, for JSON."""
        return {
            "gap": self.gap.tolist(),
            "interfaces": self.interfaces.tolist(),
            "pairs": self.pairs.tolist(),
            "isolated": self.isolated.tolist(),
            "plateau": list(self.plateau),
            "chosen": self.chosen,
        }


@checked_call
def gap_sweep(
    assembly: Assembly,
    gaps: Sequence[float] | Floats | None = None,
    *,
    options: DetectionOptions | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
) -> GapSweep:
    """Find the contacts with many gap tolerances.

    Ended early, the sweep has the smallest gaps, at least one.

    Parameters
    ----------
    assembly
    gaps
        Relative to the block size; 26 from 1e-6 to 0.1 when left out.
    options
        All other tolerances.

    Raises
    ------
    InputError
        No gap, or one out of range.

    Examples
    --------
    >>> from drystone.models import tower
    >>> gap_sweep(tower(3), [1e-5, 1e-3]).interfaces.tolist()
    [2, 2]
    """
    wanted = np.geomspace(FINEST, COARSEST, 26) if gaps is None else np.unique(gaps)
    tried = frozen_floats(wanted, (None,), "gaps")
    if len(tried) == 0 or tried[0] <= 0.0:
        raise InputError("gaps must be above zero", remedy="give for example 1e-4, 1e-3, 1e-2")
    base = DetectionOptions.of(options)
    count = partial(_counts, assembly, base)
    clock = Clock(time_limit_s, stop)
    rows: list[tuple[int, int, int]] = []
    with WorkerPool(executor) as pool:
        for row in pool.answers(count, tried.tolist(), lambda: bool(rows) and clock.late()):
            rows.append(row)
            if progress is not None:
                progress("gap sweep", len(rows), len(tried))
    table = frozen(np.array(rows, dtype=np.intp))
    return GapSweep(frozen(tried[: len(rows)]), table[:, 0], table[:, 1], table[:, 2])


def _counts(assembly: Assembly, options: DetectionOptions, gap: float) -> tuple[int, int, int]:
    report = find_contacts(assembly, options=replace(options, gap=gap, inexact=False)).report
    return len(report.area), report.pair_count, len(report.isolated)
