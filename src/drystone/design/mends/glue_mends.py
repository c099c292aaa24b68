"""Glue in joints of a region."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from drystone.base.arrays import Ints
from drystone.design.causes.diagnosis_words import glue_words, newtons
from drystone.design.causes.glue_needed import STRONGEST, GlueTrial, glue_trials, glued
from drystone.design.mends.bench import ALL, MANY, Bench, MendCandidate
from drystone.design.surgery.joint_changes import Change
from drystone.model import Model

SHARES = (0.01, 0.1, 0.3, 1.0)
"""Strengths that are tried before the least one is searched, by the largest one."""


def glue_mends(bench: Bench) -> Iterator[MendCandidate]:
    """Glue in one joint: the least strength with which the region stands.

    In a larger region, the same glue in all joints that would pull.
    """
    at = {whole: k for k, whole in enumerate(bench.interfaces.tolist())}
    pulls = bench.region.needs.pulls
    pulling = [(at[pull.interface], pull.force) for pull in pulls if pull.interface in at]
    trials = glue_trials(bench.local, len(bench.own), pulling)
    if not trials:
        bench.fail("glue", "none of its joints would pull")
        return
    free = [trial for trial in trials if all(bench.may_change(k) for k in trial.interfaces)]
    if not free:
        joints = [k for trial in trials for k in trial.interfaces]
        ends = (bench.local.contacts.block_a[joints], bench.local.contacts.block_b[joints])
        bench.fail("glue", f"its joints may not be changed (kept: {bench.kept(*ends)})")
        return
    found = False
    for trial in free:
        value = _least(bench, trial)
        if value is not None:
            found = True
            yield MendCandidate(
                "glue",
                partial(glue_words, bench.local, trial.interfaces),
                value,
                partial(_change, trial.interfaces),
                joints=len(trial.interfaces),
                added=len(trial.interfaces),
                most=trial.most,
                close=trial.close,
            )
    if found:
        return
    what = f"it falls with glue of {STRONGEST:g} times its weight in any one of its joints"
    if len(bench.own) > MANY:
        count = len(free[0].interfaces)
        what = f"it falls with glue of {newtons(free[0].most)} in the {count} joints that pull"
    bench.fail("glue", what, *(_change(trial.interfaces, trial.most) for trial in free))


def _least(bench: Bench, trial: GlueTrial) -> float | None:
    """The least strength with which the region stands at the margin."""
    low, steps = 0.0, tuple(share * trial.most for share in SHARES)
    if bench.as_diagnosed and len(bench.own) <= ALL:
        # the least one without a margin is known
        joints = set(bench.interfaces[list(trial.interfaces)].tolist())
        known = [g.strength for g in bench.region.needs.glue if set(g.interfaces) == joints]
        if not known:
            return None
        low = known[0] - trial.close
        steps = (known[0], *(x for x in steps if x > known[0]))
    return bench.least(partial(_change, trial.interfaces), steps, trial.close, low)


def _change(joints: tuple[int, ...], strength: float) -> Change:
    """Glue in some interfaces of a local model."""

    def make(model: Model, _: Ints, interfaces: Ints) -> Model:
        return glued(model, interfaces[np.array(joints)], strength)

    return make
