"""What falls, how it begins to move, and what is missing: for a person and as numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.base.arrays import Floats, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.progress import Progress
from drystone.base.settings import Options, checked_call
from drystone.design.causes import diagnosis_words
from drystone.design.causes.joint_motion import JointState, joint_states
from drystone.design.causes.missing import (
    SEARCHED,
    Needs,
    ballast_needed,
    friction_needed,
    one_force,
    pulls_of,
)
from drystone.design.causes.prop_forces import QUICK, least_prop
from drystone.design.causes.regions import first_motion_of, interfaces_of, local_model, regions_of
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability import check, solve_cra_penalty
from drystone.stability.problem import Clock


@dataclass(frozen=True)
class DiagnosisOptions(Options):
    """Options of :func:`diagnose`.

    Attributes
    ----------
    needs
        Look for the prop, the friction, the ballast and the glue that would hold each region;
        without it only what falls, how, and the force that is missing are told.
    regions
        How many are looked at, the heaviest first.
    """

    needs: bool = True
    regions: int = 20

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_below(1, "regions")


@dataclass(frozen=True, eq=False)
class Region(OneLine):
    """Connected blocks that fall or need help.

    Attributes
    ----------
    blocks
        Positions of the blocks in the model.
    neighbours
        Positions of the blocks that touch them, which are fixed in the local model.
    local
        The model of the region alone: its blocks, free, then its neighbours.
    verdict
        Of the local model.
    joints
        How each block begins to move at each of its interfaces.
    needs
        What would hold it.
    sentence
        What happens, and what to do.
    """

    blocks: tuple[int, ...]
    neighbours: tuple[int, ...]
    local: Model
    verdict: Verdict
    joints: tuple[JointState, ...]
    needs: Needs
    sentence: str

    def _summary(self) -> str:
        return f"{counted(len(self.blocks), 'block')}, '{self.sentence}'"


@dataclass(frozen=True, eq=False)
class Diagnosis(OneLine):
    """Where a model falls, why, and what is missing.

    Attributes
    ----------
    result
        Of the check, or of the penalty form where the check was undecided.
    regions
        The heaviest first; empty where it stands.
    motion : (n, 6) [m, rad]
        How the blocks begin to move; the fastest one moves by about its size.
    friction
        One coefficient for all joints at which the whole model was found to stand; ``None`` where
        it stands already or none was found.
    others
        Blocks of regions that were not looked at.
    stopped
        Why regions were told without what would hold them; empty where nothing was left out.
    """

    result: Result
    regions: tuple[Region, ...]
    motion: Floats
    friction: float | None = None
    others: tuple[int, ...] = ()
    stopped: str = ""

    def _summary(self) -> str:
        told = counted(len(self.regions), "region")
        return f"{self.result.verdict.value}, {told}, '{'; '.join(self.sentences)}'"

    @property
    def model(self) -> Model:
        """What was asked about."""
        return self.result.model

    @property
    def sentences(self) -> tuple[str, ...]:
        """One for each region; one that says so where it stands."""
        if not self.regions:
            return (diagnosis_words.nothing(self.result),)
        said = [region.sentence for region in self.regions]
        if self.others:
            more = counted(len(self.others), "more block falls", "more blocks fall")
            said.append(f"{more}: {diagnosis_words.names_of(self.model, self.others)}")
        if self.friction is not None:
            said.append(diagnosis_words.friction_of_all(self.friction))
        return tuple(said)

    @property
    def props(self) -> tuple[Floats, Floats]:
        """Points (p, 3) [m] and forces (p, 3) [N] of one prop for each region.

        The support from below where one holds, else the force that is missing.
        """
        points, forces = [], []
        for region in self.regions:
            needs = region.needs
            points.append(needs.point if needs.support is None else needs.support.point)
            forces.append(needs.force if needs.support is None else needs.support.force)
        return np.array(points).reshape(-1, 3), np.array(forces).reshape(-1, 3)

    def to_dict(self) -> dict[str, Any]:
        """Plain values: forces in N, moments in N m, lengths in m."""
        return diagnosis_words.plain(self)


@checked_call
def diagnose(
    given: Given,
    *,
    options: DiagnosisOptions | None = None,
    result: Result | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Diagnosis:
    """Why a model falls, block by block, and what would hold it.

    Blocks that fall are grouped into regions that touch each other. Each region is looked at alone,
    its neighbours fixed: how it begins to move, which joints carry nothing, slide or are hinges,
    and the least prop, friction, ballast and glue with which it stands.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    options
    result
        A check of this model, where there is one already.
    progress
    stop
        Asked often; True ends the search for what would hold the regions.
    time_limit_s
        After it regions are told without what would hold them.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        What was given cannot be made into a model, or the result is of another one.

    Examples
    --------
    >>> from drystone.models import h_model
    >>> found = diagnose(h_model(), friction=0.9)
    >>> for part in found.sentences[0].split("; "):
    ...     print(part)
    block 'block' slides down along 'left' and 'right'
    nothing presses on it
    a support that takes 33.9 kN at (0, 0, -0.2) m would hold it
    """
    chosen = DiagnosisOptions.of(options)
    model = as_model(given, **how)
    if result is not None and result.model is not model:
        raise InputError("the result is of another model", remedy="leave it out")
    clock = Clock(time_limit_s, stop)
    if progress is not None:
        progress("check", 0, 2)
    answer = check(model, stop=clock.late) if result is None else result
    if answer.stable:
        return Diagnosis(answer, (), frozen(np.zeros((len(model), 6))))
    if answer.prop is None or not answer.falling:
        answer = solve_cra_penalty(model, stop=clock.late, time_limit_s=clock.left_s)
    if answer.prop is None or not answer.falling:
        return Diagnosis(answer, (), frozen(np.zeros((len(model), 6))), stopped=clock.reason)
    prop = np.zeros((len(model), 6))
    prop[list(answer.falling)] = answer.prop[list(answer.falling)]
    groups = regions_of(model, answer.falling)
    regions = []
    looked = groups[: chosen.regions]
    for number, blocks in enumerate(looked):
        if progress is not None:
            progress("regions", number, len(looked))
        regions.append(_region(model, blocks, answer, prop, chosen, clock.late))
    others = tuple(i for blocks in groups[chosen.regions :] for i in blocks)
    wanted = chosen.needs and not others and not clock.late()
    friction = _friction_of_all(model, regions) if wanted else None
    motion = frozen(first_motion_of(model, prop))
    return Diagnosis(answer, tuple(regions), motion, friction, others, clock.reason)


def _region(
    model: Model,
    blocks: tuple[int, ...],
    answer: Result,
    prop: Floats,
    options: DiagnosisOptions,
    late: Callable[[], bool],
) -> Region:
    """A region, looked at with its neighbours fixed."""
    local, position = local_model(model, blocks)
    inside = np.zeros(len(model), dtype=bool)
    inside[list(blocks)] = True
    alone = (
        solve_cra_penalty(local, stop=late)
        if options.needs
        else check(local, options=QUICK, stop=late)
    )
    own = tuple(range(len(blocks)))
    wrench = prop[list(blocks)]
    if alone.prop is not None and not alone.stable and np.any(alone.prop):
        wrench = np.array(alone.prop[list(own)])
    mine = np.zeros((len(model), 6))
    mine[list(blocks)] = wrench
    interfaces = interfaces_of(model, blocks)
    motion = first_motion_of(model, mine)
    joints = joint_states(
        model,
        inside,
        interfaces,
        motion,
        answer.force if answer.force is not None else answer.force_with_props,
    )
    force, point = one_force(model, blocks, wrench)
    support = friction = ballast = None
    if options.needs and not alone.stable and not late():
        neediest = sorted(own, key=lambda i: -float(np.linalg.norm(wrench[i, :3])))[:SEARCHED]
        held = least_prop(local, neediest, motion[position])
        if held is not None:
            support = replace(held[1], block=blocks[held[1].block])
        friction = None if late() else friction_needed(local)
        ballast = None if late() else ballast_needed(local, own)
        if ballast is not None:
            ballast = replace(ballast, block=blocks[ballast.block])
    between = np.flatnonzero(interfaces)
    pulls = pulls_of(alone, between) if alone.contacts.count == len(between) else ()
    glued = "glue cannot" not in alone.message and bool(pulls)
    needs = Needs(
        frozen(wrench), frozen(force), frozen(point), support, pulls, glued, friction, ballast
    )
    return Region(
        blocks,
        tuple(position[len(blocks) :].tolist()),
        local,
        alone.verdict,
        joints,
        needs,
        diagnosis_words.sentence(model, blocks, joints, needs),
    )


def _friction_of_all(model: Model, regions: list[Region]) -> float | None:
    """One coefficient of all joints that was found to hold the whole model.

    What each region needs alone is needed by all; whether it is enough is checked.
    """
    each = [region.needs.friction for region in regions]
    if any(value is None for value in each):
        return None
    most = max(value for value in each if value is not None)
    rough = np.maximum(model.contacts.friction, most)
    stands = check(model.with_friction(rough), options=QUICK).stable
    return most if stands else None


__all__ = ["Diagnosis", "DiagnosisOptions", "Region", "diagnose"]
