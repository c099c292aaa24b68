"""Connected blocks that fall, the model of each such region, and the wrenches that it needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse

from drystone.base.arrays import Bools, Floats, Ints, marked
from drystone.base.ragged import linked
from drystone.base.settings import Stop
from drystone.design.margin import LARGE_REGION, QUICK
from drystone.formulations.corner_forces import FrictionCone, add_contact_rows, add_corner_forces
from drystone.model import Model
from drystone.programs import solve_cra_penalty, solve_rbe
from drystone.programs.cra import glued_state
from drystone.programs.rbe import BALANCE_TOLERANCE
from drystone.results import Result
from drystone.solvers.program import ConicStatus, ProgramBuilder
from drystone.solvers.threads import one_blas_thread
from drystone.stability import check
from drystone.stability.problem import FALLING_SHARE, Problem

_UNIQUE = 1e-8
"""Cost of the forces of the joints, by that of the wrenches: of many that balance the load it takes
those spread evenly, and changes the wrenches by less than the tolerance of a balance."""


def regions_of(model: Model, needy: Sequence[int]) -> list[tuple[int, ...]]:
    """Blocks that need help, in groups that touch each other; the heaviest group first.

    Examples
    --------
    >>> from drystone.models import tower
    >>> regions_of(Model.of(tower(5)), [1, 3, 4])
    [(3, 4), (1,)]
    """
    chosen = marked(list(needy), len(model))
    a, b = model.contacts.block_a, model.contacts.block_b
    both = chosen[a] & chosen[b]
    part = linked(a[both], b[both], len(model))
    members = np.flatnonzero(chosen)
    groups = [tuple(members[part[members] == p].tolist()) for p in np.unique(part[members])]
    mass = model.assembly.mass
    return sorted(groups, key=lambda group: -float(mass[list(group)].sum()))


def local_model(model: Model, region: Sequence[int]) -> tuple[Model, Ints]:
    """The blocks of a region, free, and those that touch them, fixed.

    Returns
    -------
    local
        The region's blocks come first.
    position : (l,)
        Of each of its blocks in the whole model.
    """
    inside = marked(list(region), len(model))
    a, b = model.contacts.block_a, model.contacts.block_b
    beside = np.zeros(len(model), dtype=bool)
    beside[a[inside[b]]] = beside[b[inside[a]]] = True
    around = np.flatnonzero(beside & ~inside)
    position = np.concatenate([np.asarray(region, dtype=np.intp), around]).astype(np.intp)
    part = model.subset(position.tolist())
    around_now = list(range(len(region), len(position)))
    local = part.with_supports(around_now) if around_now else part
    return local.with_contacts(local.contacts.select(local.active)), position


def interfaces_of(model: Model, region: Sequence[int]) -> Bools:
    """(m,) interfaces at which a block of the region takes part."""
    inside = marked(list(region), len(model))
    touched: Bools = inside[model.contacts.block_a] | inside[model.contacts.block_b]
    return touched & model.active


def with_wrenches(answer: Result, stop: Callable[[], bool], left_s: float = np.inf) -> Result:
    """The result of a check, with the blocks that fall and the wrench that each of them needs.

    Where the check has found none, they are those of the penalty form. It is for dry joints only;
    for others they are the least wrenches that balance the load together with forces that the
    joints can carry.

    Parameters
    ----------
    answer
        Of a model that does not stand.
    stop
    left_s : [s]
        Time limit.
    """
    if answer.prop is not None and answer.falling:
        return answer
    model = answer.model
    if model.contacts.plain.all():
        some = solve_cra_penalty(model, stop=stop, time_limit_s=left_s)
        if some.stable or some.prop is None:
            return answer
        return replace(answer, prop=some.prop, force_with_props=some.force, falling=some.falling)
    found = _least_wrenches(model, stop)
    if found is None:
        return answer
    prop, force = found
    share = np.linalg.norm(prop[:, :3], axis=1) + np.linalg.norm(prop[:, 3:], axis=1) / (
        model.assembly.size
    )
    load = float(np.linalg.norm(model.load.wrench[model.assembly.free, :3], axis=1).max())
    if share.max() <= BALANCE_TOLERANCE * load:
        return answer
    needy = np.flatnonzero(share > FALLING_SHARE * share.max())
    falling = tuple(needy.tolist())
    return replace(answer, prop=prop, force_with_props=force, falling=falling)


def _least_wrenches(
    model: Model, stop: Callable[[], bool] | None = None
) -> tuple[Floats, Floats] | None:
    """The least wrenches on free blocks with which joints of any capacity balance the load.

    ::

        minimise  1/2 |w|^2   subject to   A f + p + w = 0,  friction and capacity of the joints

    They are zero where forces of the joints balance the load, else they act against a mechanism.
    Moments are divided by the sizes of the blocks.

    Returns
    -------
    wrench : (n, 6) [N, N m]
    force : (k, 3) [N], local n, u, v
        With which they balance the load. ``None`` in place of both if the solver fails.
    """
    problem = Problem.build(model)
    statics = problem.statics
    count = 6 * statics.free_count
    program = ProgramBuilder()
    forces = add_corner_forces(program, statics, quadratic=_UNIQUE)
    held = program.variable("wrench", count, quadratic=1.0)
    program.equal(
        "equilibrium",
        -statics.load.ravel(),
        *forces.wrench(statics),
        (held, sparse.identity(count, format="csc")),
    )
    add_contact_rows(program, statics, FrictionCone.exact(), forces)
    made = program.build()
    raw = made.solve(stop=stop)
    if raw.status is not ConicStatus.SOLVED:
        return None
    wrench = problem.wrench(made.value(raw.x, "wrench").reshape(-1, 6))
    return wrench, problem.force(raw.x[made.variables["force"]].reshape(-1, 3))


def solve_alone(local: Model, stop: Callable[[], bool]) -> Result:
    """The local model of a region: its verdict, the wrenches that it needs and the tension.

    The tension is that of :func:`tension_if_glued`. That of a large region is not sought here.
    """
    large = local.assembly.free.size > LARGE_REGION
    if local.contacts.plain.all() and not large:
        return solve_cra_penalty(local, stop=stop)
    answer = check(local, options=QUICK, stop=stop)
    if answer.stable or stop():
        return answer
    answer = with_wrenches(answer, stop)
    return answer if large else replace(answer, tension=tension_if_glued(local, stop))


@one_blas_thread()
def tension_if_glued(local: Model, stop: Stop | None = None) -> Floats | None:
    """The tension (k,) [N] of the corners if all joints were glued.

    It is that of the penalty form, or for joints that already pull or cohere that of RBE beyond
    what they carry.
    """
    if not local.contacts.plain.all():
        return solve_rbe(local, stop=stop).tension
    problem = Problem.build(local)
    return problem.force(glued_state(problem, stop=stop).tension[:, None])[:, 0]
