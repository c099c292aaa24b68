"""Mends of a model whose supports move: each one is followed while they move."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.design import DesignMargin, MendOptions
from drystone.live.moved_supports import follow
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.settlement import End, LargeDisplacement
from drystone.stability import check

FOLLOWED_KINDS = tuple(kind for kind in MendOptions().kinds if kind != "glue")
"""What glue still carries in a joint that has moved is not known."""
_HASTE = 4.0
"""How much longer the increments of a quick look are. What it finds is followed once more in those
of the verdict. Chosen: it takes a quarter of the time."""
_PRESSES = 1e-6
"""Normal force by the largest one from which on a corner touches; above the accuracy of rest."""


@dataclass(frozen=True)
class AfterMoving(DesignMargin):
    """A model is safe where it still stands after its supports have moved.

    Attributes
    ----------
    motion
        Translation and rotation vector (6,) [m, rad] of supports, by their names.
    """

    motion: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @classmethod
    def of_supports(cls, model: Model, motion: Floats) -> AfterMoving:
        """After a motion (n, 6) of the supports of a model."""
        names = model.assembly.names
        return cls(motion={names[i]: tuple(motion[i]) for i in np.flatnonzero(motion.any(axis=1))})

    def holds(
        self,
        model: Model,
        stop: Callable[[], bool] | None = None,
        *,
        settle: bool = True,
        near: list[dict[int, Floats]] | None = None,
    ) -> Result:
        """The answer after the motion; of what falls, of the blocks where they fall."""
        del settle, near  # the blocks are followed
        found = self._followed(model, stop, 1.0)
        if found is None:
            return check(model, stop=stop)
        if found.end is not End.FALLS:
            verdict = Verdict.STABLE if found.end is End.REACHED else Verdict.UNDECIDED
            return Result("settlement", verdict, model, found.message, stopped=found.stopped)
        there = moved_model(found)
        result = check(there, stop=stop)
        if result.falls:
            return result
        return Result("settlement", Verdict.UNSTABLE, there, found.message)

    def stands(
        self,
        model: Model,
        *,
        quick: bool = False,
        stop: Callable[[], bool] | None = None,
        near: list[dict[int, Floats]] | None = None,
    ) -> bool:
        """Whether a model stands after the motion; ``quick`` by longer increments."""
        found = self._followed(model, stop, _HASTE if quick else 1.0)
        if found is None:
            return super().stands(model, quick=quick, stop=stop, near=near)
        return found.end is End.REACHED

    def meets(self, result: Result) -> bool:
        """Whether it stands; there is one contact stiffness."""
        return result.stable

    def _followed(
        self, model: Model, stop: Callable[[], bool] | None, pace: float
    ) -> LargeDisplacement | None:
        """None where no support of the model moves, or nothing follows."""
        assembly = model.assembly
        motion = np.zeros((len(model), 6))
        for name, by in self.motion.items():
            if name in assembly and assembly.fixed[assembly.index(name)]:
                motion[assembly.index(name)] = by
        if not motion.any() or not len(assembly.free):
            return None
        moving = model.with_load(replace(model.load, motion=motion))
        return follow(moving, stop=stop, pace=pace)


def moved_model(found: LargeDisplacement) -> Model:
    """The blocks where they rest or fall, with their joints as far as these press there."""
    model, last = found.model, found.fallen or found.states[-1]
    normal, contacts = last.force[:, 0], last.contacts
    touches = normal > _PRESSES * float(normal.max(initial=0.0))
    joint = np.zeros(len(contacts), dtype=bool)
    joint[contacts.interface[touches]] = True
    corner = touches[joint[contacts.interface]]
    some = contacts.select(joint)
    pressing = replace(some, point=some.point[corner], interface=some.interface[corner])
    pressing = replace(pressing, area=pressing.corners.sum(pressing.tributary))
    there = model.assembly.moved(last.positions)
    return replace(model, assembly=there, contacts=pressing, report=None)
