"""Joints sharpened until a structure stands, then each one taken back to the least that holds.

Source: Kao 2023, section 6.3.3: joints are made wedges where the penalty form shows tension.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Unpack

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.base.declared import Offered
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, Options, checked_call
from drystone.design.changed import Changed, Kept
from drystone.design.joint_cut import JointPlane, joint_plane, recut
from drystone.design.margin import DesignMargin
from drystone.design.mends import kept_blocks, stands_already
from drystone.design.search import bracket, each_needed
from drystone.design.surgery import wedge_cut
from drystone.io.opening import Given, LongHow, as_model
from drystone.model import Model
from drystone.programs.cra import glued_state
from drystone.results import Result
from drystone.stability import check
from drystone.stability.problem import Problem


@dataclass(frozen=True, eq=False)
class PlaneJoints(OneLine):
    """The joints of a structure as they were, each of which may be made a wedge.

    Attributes
    ----------
    model
        With plane joints.
    usable : (j,)
        Joints that have an area, are convex, and belong to blocks that may be changed.
    planes
        Of these joints, by their numbers.
    """

    model: Model
    usable: Bools
    planes: Mapping[int, JointPlane]

    @classmethod
    def of(cls, model: Model, keep: frozenset[int] = frozenset()) -> PlaneJoints:
        """The joints of a model; those of the blocks to keep stay plane."""
        contacts = model.contacts
        usable = model.active.copy()
        planes: dict[int, JointPlane] = {}
        for k in np.flatnonzero(usable).tolist():
            if {int(contacts.block_a[k]), int(contacts.block_b[k])} & keep:
                usable[k] = False
                continue
            try:
                planes[k] = joint_plane(model, k)
            except InputError:
                usable[k] = False
        return cls(model, usable, planes)

    def wedged(self, sharpness: Floats) -> Model:
        """The model with wedges in its joints.

        Parameters
        ----------
        sharpness : (j,) [degrees]
            Zero where the joint stays plane.

        Raises
        ------
        InputError
            A wedge would remove a face or cut a block in two, or two wedges would take the same
            part of a block.
        """
        sharp = np.flatnonzero(sharpness > 0.0).tolist()
        if not sharp:
            return self.model
        return recut(self.model, [wedge_cut(self.planes[k], float(sharpness[k])) for k in sharp])

    def tension(self, model: Model) -> Floats:
        """Tension (j,) [N] of each joint if all joints of a model with wedges were weakly glued.

        Glue is the penalty form of Kao et al. 2022, eq. 5.8, with friction still bounded by what
        presses; see :func:`drystone.solve_cra_penalty`.
        """
        problem = Problem.build(model)
        pull = problem.force(glued_state(problem).tension[:, None])[:, 0]
        contacts, before = model.contacts, self.model.contacts
        whole = np.bincount(contacts.interface, pull, minlength=contacts.count)
        tension = np.zeros(before.count)
        for i in np.flatnonzero(whole > 0.0).tolist():
            a, b = int(contacts.block_a[i]), int(contacts.block_b[i])
            near = _interface_near(self.model, a, b, contacts.centroid[i])
            if near is not None:  # else two blocks touch that did not touch before
                tension[near] += whole[i]
        return tension


def _interface_near(model: Model, one: int, other: int, centre: Floats) -> int | None:
    """The interface between two blocks whose middle is nearest to a point (3,) [m]."""
    contacts = model.contacts
    ends = np.sort(np.stack([contacts.block_a, contacts.block_b], axis=1), axis=1)
    some = np.flatnonzero((ends == sorted((one, other))).all(axis=1))
    if not len(some):
        return None
    away = np.linalg.norm(contacts.centroid[some] - centre, axis=1)
    return int(some[int(np.argmin(away))])


_TENSE = 0.01
"""A joint shows tension from this share of the largest tension of a joint on, chosen: glue that
stretches puts a trace of tension into every hinge."""


@dataclass(frozen=True)
class SharpenOptions(Options):
    """Options of :func:`sharpen`.

    Attributes
    ----------
    margin
        Margin with which it has to stand: ``tilt=2deg`` to each side, ``load=1.2`` times the load,
        ``friction=0.9x``, or ``sensitive``, where STABLE after settling is enough
        (it stands for all contact stiffnesses).
    step : [degrees] > 0
        By which joints with tension are sharpened in each round.
    most : [degrees] > 0, < 80
        Largest sharpness of a wedge.
    least : [degrees] >= 0
        Least sharpness of a wedge: one that would be flatter is made plane or as sharp as this.
    close : [degrees] >= 0.01
        Accuracy of each sharpness: with any joint less sharp by so much, it no longer stands.
    keep
        Blocks whose joints stay plane: names and patterns, separated by commas, or positions.
    """

    margin: DesignMargin = field(default_factory=DesignMargin)
    step: float = 10.0
    most: float = 60.0
    least: float = 5.0
    close: float = 0.5
    keep: tuple[int | str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, upper in (("step", "most"), ("least", "most"), ("close", "step")):
            value, end = getattr(self, name), getattr(self, upper)
            if value > end:
                raise InputError(f"{name} is {value:g} degrees", remedy=f"give up to {end:g}")


@checked_call
def sharpen(
    given: Given,
    *,
    options: SharpenOptions | None = None,
    **how: Unpack[LongHow],
) -> Changed:
    """Make plane joints wedges of two planes where tension appears, until the structure stands.

    In each round the joints that would pull if they were glued are made sharper by a step. Once it
    stands, all wedges together are taken back to the least sharpness with which it still stands.
    Then wedges that are not needed are made plane, and each one that is left is made as flat as
    the structure stands with. Each check needs the one before, so an ``executor`` has nothing to
    share.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options

    Returns
    -------
    Changed
        The ridge of each wedge is horizontal. Where no sharpness holds the structure, it says so,
        with the joints as sharp as they were made.

    Raises
    ------
    InputError
        What was given cannot be made into a model, a block to keep does not exist, or no joint may
        be changed.

    Examples
    --------
    >>> from drystone.models import arch
    >>> found = sharpen(arch(0.15, voussoirs=6), friction=0.7)
    >>> found.stands, found.message
    (True, 'it stands already: ask for a margin to make it stand more firmly')
    """
    chosen = SharpenOptions.of(options)
    clock = Clock.of(how)
    model = as_model(given, **how)
    keep = kept_blocks(model, chosen.keep)
    joints = PlaneJoints.of(model, keep)
    none = np.zeros(model.contacts.count)
    first = chosen.margin.holds(model)
    if chosen.margin.meets(first):
        told = (stands_already(chosen.margin),)
        return Changed(model, model, first, True, log=told, x=none)
    if not joints.usable.any():
        kept = ", ".join(model.assembly.names[i] for i in sorted(keep))
        what = "no joint may be changed" + (f": the joints of {kept} stay" if kept else "")
        raise InputError(what, remedy="let other blocks change, or try 'drystone mend'")
    return _Sharpening(joints, chosen, clock).run()


class _Sharpening:
    """The rounds until it stands, then wedges taken back."""

    def __init__(self, joints: PlaneJoints, options: SharpenOptions, clock: Clock) -> None:
        self.joints, self.options, self.clock = joints, options, clock
        self.limit = np.where(joints.usable, options.most, 0.0)

    def run(self) -> Changed:
        sharpness, rounds, stands = self.rounds()
        message = ""
        if stands:
            close, late = self.options.close, self.clock.late
            _, high = bracket(
                lambda most: self.holds(np.minimum(sharpness, most)),
                0.0, float(sharpness.max()), 0.5 * close, late,
            )  # fmt: skip
            tell = partial(self.clock.tell, "taking each wedge back")
            lowered = np.minimum(sharpness, high)
            buildable = np.where(lowered > 0.0, np.maximum(lowered, self.options.least), 0.0)
            if np.array_equal(buildable, lowered) or self.holds(buildable):
                lowered = buildable
            sharpness, known = each_needed(
                lowered, self.holds, close=close, late=late, tell=tell, smallest=self.options.least
            )
            message = f"stands with {_some(sharpness)} sharpened, by up to {sharpness.max():.2f} "
            message += "degrees"
            if not known:
                message += "; it was stopped before each of them was known to be needed"
        before, model = self.joints.model, self.joints.wedged(sharpness)
        result = self.options.margin.holds(model)
        message = message or self.why(sharpness, result)
        names, contacts = before.assembly.names, before.contacts
        kept = [
            Kept(
                "wedge",
                (names[contacts.block_a[k]], names[contacts.block_b[k]]),
                f"made a wedge of {sharpness[k]:.3g} degrees",
                float(sharpness[k]),
            )
            for k in np.flatnonzero(sharpness > 0.0)
        ]
        words = f"{_some(sharpness)} made wedges of up to {sharpness.max():.3g} degrees"
        return Changed(
            before, model, result, self.options.margin.meets(result), words if kept else "",
            tuple(kept), (message,), sharpness, rounds=rounds,
        )  # fmt: skip

    def rounds(self) -> tuple[Floats, int, bool]:
        """Sharpness (j,), number of rounds, and whether it stands."""
        joints, step = self.joints, self.options.step
        sharpness, model = np.zeros(joints.model.contacts.count), joints.model
        most = int(np.ceil(self.options.most / step))
        for number in range(most):
            if self.clock.late():
                return sharpness, number, False
            self.clock.tell("sharpening", number, most)
            sharper, model = self.sharper(sharpness, self.tense(model))
            if np.array_equal(sharper, sharpness):
                return sharpness, number, False
            sharpness = sharper
            if self.options.margin.stands(model):
                return sharpness, number + 1, True
        return sharpness, most, False

    def tense(self, model: Model) -> Bools:
        """The joints (j,) that show tension, in the first case of the margin that falls."""
        margin = self.options.margin
        options = margin.options()
        for case in (model, *margin.cases(model)):
            if not margin.meets(check(case, options=options)):
                tension = self.joints.tension(case)
                return tension > _TENSE * tension.max(initial=0.0)
        return np.zeros(self.joints.model.contacts.count, dtype=bool)

    def sharper(self, sharpness: Floats, tense: Bools) -> tuple[Floats, Model]:
        """The joints that show tension sharper by a step, each as far as its blocks allow."""
        step = self.options.step
        wanted = np.minimum(np.where(tense, sharpness + step, sharpness), self.limit)
        try:
            return wanted, self.joints.wedged(wanted)
        except InputError:  # some do not fit beside the others: find which
            fitting, model = sharpness.copy(), self.joints.wedged(sharpness)
            for k in np.flatnonzero(wanted > sharpness).tolist():
                more = np.where(np.arange(len(wanted)) == k, wanted, fitting)
                try:
                    fitting, model = more, self.joints.wedged(more)
                except InputError:
                    self.limit[k] = sharpness[k]
            return fitting, model

    def why(self, sharpness: Floats, result: Result) -> str:
        """Why no sharpness holds it."""
        if self.clock.late():
            return "it was stopped before it stood"
        if not sharpness.any():
            return (
                "no joint that may be changed shows tension, so that wedges do not help: "
                "'drystone mend' tries other changes"
            )
        some, most = _some(sharpness), sharpness.max()
        what = "sharper wedges do not fit or do not help, try"
        if most >= self.options.most:
            what = "allow sharper wedges, or try"
        told = f"it does not stand with {some} sharpened by up to {most:g} degrees"
        if result.stable:
            told += " for all contact stiffnesses"
        return f"{told}: {what} 'drystone mend'"

    def holds(self, sharpness: Floats) -> bool:
        """Whether the structure stands with a sharpness (j,); False where the parts do not fit."""
        try:
            model = self.joints.wedged(sharpness)
        except InputError:
            return False
        return self.options.margin.stands(model)


def _some(sharpness: Floats) -> str:
    return counted(int((sharpness > 0.0).sum()), "joint")


OFFERED = Offered(
    sharpen, "arch.json --most 50 --keep springer-left", ("options.most", "options.keep"), "model"
)
