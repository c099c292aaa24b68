"""Rest states for other contact stiffnesses than the uniform one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.progress import Clock
from drystone.checks import check_several
from drystone.formulations.rest import compliance
from drystone.formulations.rest.compliance import Compliance
from drystone.formulations.rest.nearby import find_rest_nearby
from drystone.formulations.rest.rest_state import start_from
from drystone.solvers.threads import one_blas_thread
from drystone.stability.attempts import Attempts, Candidate, Record
from drystone.stability.check_options import CheckOptions
from drystone.stability.problem import Problem
from drystone.stability.screening import AT_REST
from drystone.stability.similar_attempts import Rest, SimilarAttempts

NONE_FOUND = np.zeros((0, 6))
"""In place of a rest state that was not found."""


@dataclass(eq=False)
class TriedStiffnesses:
    """What checks of one model have tried, which other checks of it need not try again.

    Attributes
    ----------
    uniform
        The rest state of uniform stiffness that was found from nothing.
    failed
        What came of the samples, by number, to which that rest state does not lead, nor a path from
        nothing.
    """

    uniform: Candidate | None = None
    failed: dict[int, Record] = field(default_factory=dict)


class StiffnessSample(NamedTuple):
    """A stiffness to try.

    Attributes
    ----------
    springs
    rests
        Similar rest states.
    briefly
        Whether to try from those only.
    known
        What came of it, where it was tried already.
    """

    springs: Compliance
    rests: Sequence[Rest]
    briefly: bool = False
    known: Record | None = None


def samples_to_try(
    attempts: Attempts,
    options: CheckOptions,
    uniform: Candidate,
    known: Mapping[int, Floats],
    within: tuple[Ints, int] | None,
    tried: TriedStiffnesses,
) -> list[StiffnessSample]:
    """The samples of the stiffness; those near known rest states are tried here, at once.

    Parameters
    ----------
    attempts, options
    uniform
        The answer of uniform stiffness.
    known, within
        As for :class:`drystone.stability.verdict.cascade.Cascade`.
    tried
        What failed from the same rest state before is tried near other known ones only.
    """
    statics = attempts.problem.statics
    tangential = options.settlement.tangential
    springs = compliance.samples(
        statics, options.samples, options.seed, within, tangential=tangential
    )
    out = []
    for number, sample in enumerate(springs, start=1):
        near = known.get(number)
        missed = near is not None and not len(near)
        rests = [] if near is None or missed else [Rest(near, True)]
        if uniform.stands:
            rests.append(
                Rest(uniform.displacement, compliance.is_even(statics, sample), uniform.path)
            )
        # a start is scaled as if forces were in proportion to the motion
        out.append(StiffnessSample(sample, rests if statics.dry else [], missed))
    first = [i for i, one in enumerate(out) if len(one.rests) > 1]
    if len(first) > 1:
        starts = [out[i].rests[0].displacement for i in first]
        found = several_nearby(attempts, [out[i].springs for i in first], starts)
        for i, one in zip(first, found, strict=True):
            stood = None if one is None else Record([one], tried=1)
            out[i] = out[i]._replace(rests=out[i].rests[1:], known=stood)
    for number, record in tried.failed.items() if uniform is tried.uniform else ():
        again = out[number - 1]
        if again.known is None and len(again.rests) == 1 and not again.briefly:
            out[number - 1] = again._replace(known=record)
    return out


def several_nearby(
    attempts: Attempts, springs: Sequence[Compliance], displacements: Sequence[Floats]
) -> list[Candidate | None]:
    """As :meth:`Attempts.nearby` of several springs.

    What is found is not counted.
    """
    problem, clock = attempts.problem, attempts.clock
    statics = problem.statics
    each = [statics.scaled_motion(one, statics.mean_length) for one in displacements]
    system = problem.system
    starts = [start_from(system, one, motion) for one, motion in zip(springs, each, strict=True)]
    states = [
        find_rest_nearby(system, one, AT_REST, start, clock.late)
        for one, start in zip(springs, starts, strict=True)
    ]
    began = clock.elapsed_s
    found = {i: state for i, state in enumerate(states) if state is not None}
    forces = [problem.force(state.force) for state in found.values()]
    moved = [problem.displacement(state.motion) for state in found.values()]
    out: list[Candidate | None] = [None] * len(states)
    residuals = check_several(problem.model, forces, moved) if found else []
    for i, force, motion, left in zip(found, forces, moved, residuals, strict=True):
        candidate = Candidate(force, motion, left)
        out[i] = candidate if candidate.stands else None
        attempts.iterations += found[i].iterations
    attempts.checking_s += clock.elapsed_s - began
    return out


@one_blas_thread()
def attempt_sample(problem: Problem, clock: Clock, lead: bool, sample: StiffnessSample) -> Record:
    """One try of other stiffnesses, first from similar rest states."""
    if sample.known is not None:
        return sample.known
    tries = SimilarAttempts(problem, clock)
    springs, rests, briefly, _ = sample
    tries.attempt_from(springs, rests, lead=lead, briefly=briefly)
    return Record(*(getattr(tries, each.name) for each in fields(Record)))
