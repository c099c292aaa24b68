"""Connected blocks that need help, and the model of each with its neighbours fixed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from drystone.base.arrays import Bools, Ints
from drystone.model import Model


def regions_of(model: Model, needy: Sequence[int]) -> list[tuple[int, ...]]:
    """Blocks that need help, in groups that touch each other; the heaviest group first.

    Examples
    --------
    >>> from drystone.models import tower
    >>> regions_of(Model.of(tower(5)), [1, 3, 4])
    [(3, 4), (1,)]
    """
    chosen = np.zeros(len(model), dtype=bool)
    chosen[list(needy)] = True
    a, b = model.contacts.block_a, model.contacts.block_b
    both = chosen[a] & chosen[b]
    links = sparse.coo_matrix((np.ones(both.sum()), (a[both], b[both])), shape=(len(model),) * 2)
    _, part = connected_components(links, directed=False)
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
    inside = np.zeros(len(model), dtype=bool)
    inside[list(region)] = True
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
    inside = np.zeros(len(model), dtype=bool)
    inside[list(region)] = True
    touched: Bools = inside[model.contacts.block_a] | inside[model.contacts.block_b]
    return touched & model.active
