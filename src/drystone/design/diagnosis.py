"""Diagnosis: falling blocks, their first motion, and missing forces."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Unpack

import numpy as np

from drystone.base.arrays import Floats, frozen
from drystone.base.errors import InputError
from drystone.base.progress import Clock, Progress, Stop, Stopped, Workers
from drystone.base.settings import Options, checked_call
from drystone.base.workers import WorkerPool
from drystone.checks import first_motion_of
from drystone.design.bench import Bench
from drystone.design.diagnosed import Diagnosis, Region
from drystone.design.joint_motion import joint_states, sentence
from drystone.design.margin import LARGE_REGION, soon_at_rest
from drystone.design.needs import Needs, one_force, pulls_of, search_needs
from drystone.design.regions import (
    interfaces_of,
    local_model,
    regions_of,
    solve_alone,
    with_wrenches,
)
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.results import Result
from drystone.stability import check


@dataclass(frozen=True)
class DiagnosisOptions(Options):
    """Options of :func:`diagnose`.

    Attributes
    ----------
    needs
        Whether to search the prop, the friction, the ballast and the glue with which each region
        stands. Without it the diagnosis has the falling blocks, their motion and the missing force
        only.
    regions
        Number of regions that are examined, the heaviest first.
    large
        Whether what regions of more than 40 blocks need is searched too: each trial is slow there.
    """

    needs: bool = True
    regions: int = 20
    large: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_below(1, "regions")


@checked_call
def diagnose(
    given: Given,
    *,
    options: DiagnosisOptions | None = None,
    result: Result | None = None,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Diagnosis:
    """Why a model falls, and what would hold it.

    Falling blocks that touch each other form a region. Each region is examined alone, with its
    neighbours fixed: its first motion, the joints that carry nothing, slide or are hinges, and the
    least prop, friction, ballast and glue with which it stands.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options
    result
        A result of a check of this model, if available.

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
    >>> for part in found.reasons[0].replace(", or", ";or").split(";"):
    ...     print(part.strip())
    block 'block' slides down along 'left' and 'right'
    nothing presses on it
    a support that gives 33.9 kN (up) at (0, 0, -0.2) m
    or the joint with 'left' turned by 0.1 degrees
    or glue between 'left' and 'block' that carries a pull, and a shear, of 15 kN would hold it
    """
    chosen = DiagnosisOptions.of(options)
    model = as_model(given, **how)
    if result is not None and result.model is not model:
        raise InputError("the result is of another model", remedy="leave it out")
    clock = Clock(time_limit_s, stop, progress)
    clock.tell("check", 0, 2)
    answer = check(model, stop=clock.late) if result is None else result
    if answer.stable:
        return Diagnosis(answer, (), frozen(np.zeros((len(model), 6))))
    answer = with_wrenches(answer, clock.late, clock.left_s)
    if answer.prop is None or not answer.falling:
        return Diagnosis(answer, (), frozen(np.zeros((len(model), 6))), stopped=clock.reason)
    prop = np.zeros((len(model), 6))
    prop[list(answer.falling)] = answer.prop[list(answer.falling)]
    groups = regions_of(model, answer.falling)
    regions: list[Region] = []
    looked = groups[: chosen.regions]
    task = partial(_region, model, answer, prop, chosen, clock)
    clock.tell("regions", 0, len(looked))
    with WorkerPool(executor) as pool:
        for region in pool.answers(task, looked):
            regions.append(region)
            clock.tell("regions", len(regions), len(looked))
    others = tuple(i for blocks in groups[chosen.regions :] for i in blocks)
    wanted = chosen.needs and not others and not clock.late()
    friction = _friction_of_all(model, regions, clock.late) if wanted else None
    motion = frozen(first_motion_of(model, prop))
    return Diagnosis(answer, tuple(regions), motion, friction, others, clock.reason)


def _region(
    model: Model,
    answer: Result,
    prop: Floats,
    options: DiagnosisOptions,
    clock: Clock,
    blocks: tuple[int, ...],
) -> Region:
    """A region, examined with its neighbours fixed."""
    late = clock.late
    inside = np.zeros(len(model), dtype=bool)
    inside[list(blocks)] = True
    interfaces = interfaces_of(model, blocks)
    local, position = local_model(model, blocks)
    large = len(blocks) > LARGE_REGION
    alone = solve_alone(local, late)
    wrench = prop[list(blocks)]
    if alone.prop is not None and not alone.stable and np.any(alone.prop):
        wrench = np.array(alone.prop[: len(blocks)])
    mine = np.zeros((len(model), 6))
    mine[list(blocks)] = wrench
    motion = first_motion_of(model, mine)
    forces = answer.force if answer.force is not None else answer.force_with_props
    joints = joint_states(model, inside, interfaces, motion, forces)
    force, point = one_force(model, blocks, wrench)
    between = np.flatnonzero(interfaces)
    pulls = pulls_of(alone.contacts, alone.tension, between)
    needs = Needs(frozen(wrench), frozen(force), frozen(point), pulls)
    if options.needs and (options.large or not large) and not alone.stable and not late():
        with contextlib.suppress(Stopped):
            for found in search_needs(Bench(model, blocks, motion, stop=late), needs):
                needs = replace(needs, **found)
    return Region(
        blocks,
        tuple(position[len(blocks) :].tolist()),
        local,
        alone.verdict,
        joints,
        needs,
        sentence(model, blocks, joints, needs),
    )


def _friction_of_all(model: Model, regions: list[Region], late: Callable[[], bool]) -> float | None:
    """The least coefficient of all joints with which the whole model stands.

    The largest need of a region alone is a lower bound; a check of the whole model confirms it.
    """
    each = [region.needs.friction for region in regions]
    if any(value is None for value in each):
        return None
    most = max(value for value in each if value is not None)
    rough = np.maximum(model.contacts.friction, most)
    with contextlib.suppress(Stopped):
        return most if soon_at_rest(model.with_friction(rough), late).stable else None
    return None
