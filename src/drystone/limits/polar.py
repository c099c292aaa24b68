"""Tilt limits in every direction."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.errors import InputError
from drystone.geometry.arrays import Floats
from drystone.limits.limits import limit_tilt
from drystone.limits.search import Bracket, Check
from drystone.limits.types import Limit, LimitOptions
from drystone.loads import LoadCase
from drystone.progress import Progress
from drystone.stability.problem import Clock


@dataclass(frozen=True, eq=False)
class TiltSweep:
    """Tilt limits about horizontal axes.

    Attributes
    ----------
    azimuth : (d,) [degrees]
        Direction towards which the assembly leans, counter-clockwise from x seen from above.
    limits : (d,)
        The axis of each is the azimuth turned by 90 degrees.
    stopped
        Why directions are missing; else empty.
    """

    azimuth: Floats
    limits: tuple[Limit, ...]
    stopped: str = ""

    @property
    def equilibrium(self) -> Floats:
        """(d,) [degrees], the largest tilt with an equilibrium; NaN where there is none."""
        return np.array([_stands(limit.equilibrium) for limit in self.limits])

    @property
    def rest(self) -> Floats:
        """(d,) [degrees], the largest tilt that the full verdict lets stand."""
        return np.array([_stands(limit.best) for limit in self.limits])

    @property
    def weakest(self) -> int:
        """The direction in which it falls first, among those that are known.

        Raises
        ------
        InputError
            None is.
        """
        if not self.limits:
            raise InputError("no direction is known", remedy="let the sweep go on")
        return int(np.argmin(np.nan_to_num(self.rest, nan=-1.0).round(6)))

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "parameter": "tilt",
            "unit": "deg",
            "azimuth": self.azimuth.tolist(),
            "weakest_azimuth": float(self.azimuth[self.weakest]) if self.limits else None,
            "limits": [limit.to_dict() for limit in self.limits],
            "stopped": self.stopped,
        }


def tilt_sweep(
    assembly: Assembly,
    contacts: Contacts,
    directions: int = 16,
    load: LoadCase | None = None,
    *,
    upper: float = 180.0,
    check: Check | None = None,
    options: LimitOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> TiltSweep:
    """The tilt limit towards equally spaced directions.

    Parameters
    ----------
    directions
        Number of azimuths, the first along x: the assembly leans towards each of them.
    executor
        Works on the directions side by side; the answer does not depend on it.
    stop
        Asked often, with an executor between the directions; True ends the sweep with the limits
        that are complete.

    Other parameters are those of :func:`limit_tilt`.
    """
    if directions < 1:
        raise InputError(f"{directions} directions", remedy="give one or more")
    azimuth = 360.0 * np.arange(directions) / directions
    angle = np.deg2rad(azimuth)
    axes = np.stack([-np.sin(angle), np.cos(angle), np.zeros(directions)], axis=1)
    clock = Clock(float("inf"), stop)
    given: dict[str, Any] = {"upper": upper, "check": check, "options": options}
    if executor is None:
        given["stop"] = clock.late
    task = partial(_one, assembly, contacts, load, **given)
    answers: Iterable[Limit]
    answers = map(task, axes) if executor is None else executor.map(task, axes)
    limits: list[Limit] = []
    for limit in answers:
        if limit.stopped:
            break
        limits.append(limit)
        if progress is not None:
            progress("directions", len(limits), directions)
        if len(limits) < directions and clock.late():
            break
    return TiltSweep(azimuth[: len(limits)], tuple(limits), clock.reason)


def _one(
    assembly: Assembly, contacts: Contacts, load: LoadCase | None, axis: Floats, **options: Any
) -> Limit:
    return limit_tilt(assembly, contacts, axis, load, **options)


def _stands(bracket: Bracket) -> float:
    return float("nan") if bracket.stands is None else bracket.stands


__all__ = ["TiltSweep", "tilt_sweep"]
