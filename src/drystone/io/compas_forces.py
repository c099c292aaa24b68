"""Forces at the corners of interfaces, as solved COMPAS assemblies and models store them.

Each corner has ``c_np`` and ``c_nn``, compression and tension, and ``c_u`` and ``c_v`` along the
axes of the interface. They act on the block towards which the axis z of the interface points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.answer import Verdict
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats
from drystone.checks import check_forces, unbalanced_wrench
from drystone.contacts import Contacts
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Result

COMPONENTS = ("c_np", "c_nn", "c_u", "c_v")

_BALANCED = 1e-6
"""Residual, and share of a pull, that count as none. Forces of compas_cra 0.8 balance to 1e-11."""


def forces_of(
    stored: Sequence[Floats | None], contacts: Contacts, turned: Bools, backwards: Bools
) -> tuple[Floats, Floats] | None:
    """Forces (k, 3) on block b and tension (k,) [N] in the order of the corners of contacts.

    Parameters
    ----------
    stored
        Of each interface the components (c, 4) of its corners, or ``None``.
    contacts
    turned : (m,)
        The stored axis z points from block b to block a.
    backwards : (m,)
        The stored corners run in reverse order.

    Returns
    -------
    None where no interface has forces for each of its corners.
    """
    force, tension = np.zeros((contacts.corner_count, 3)), np.zeros(contacts.corner_count)
    any_forces = False
    for i, given in enumerate(stored):
        rows = slice(contacts.start[i], contacts.start[i + 1])
        if given is None or given.shape != (rows.stop - rows.start, len(COMPONENTS)):
            continue
        push, pull, u, v = (given[::-1] if backwards[i] else given).T
        force[rows] = np.column_stack([push - pull, -u if turned[i] else u, v])
        tension[rows] = np.maximum(pull, 0.0)
        any_forces = True
    return (force, tension) if any_forces else None


def solved(
    assembly: Assembly,
    contacts: Contacts,
    found: tuple[Floats, Floats] | None,
    displacement: Floats | None = None,
) -> tuple[Result, ...]:
    """The result of forces that were found elsewhere, under the gravity that fits them best.

    COMPAS stores neither the loads nor, in most files, the density with which it solved.

    Parameters
    ----------
    assembly
    contacts
    found
        What :func:`forces_of` made.
    displacement : (n, 6) [m, rad]

    Returns
    -------
    One result, or none where there are no forces.
    """
    if found is None:
        return ()
    force, tension = found
    nothing = Model(assembly, contacts, LoadCase(np.zeros((len(assembly), 6)), "none"))
    pushed = unbalanced_wrench(nothing, force)[0][assembly.free, :3]
    mass = assembly.mass[assembly.free]
    gravity = -(mass @ pushed) / (mass @ mass)
    model = Model(assembly, contacts, gravity.tolist())
    residuals = check_forces(model, force)
    pulls = bool((tension > _BALANCED * np.abs(force).max()).any())
    balanced = residuals.equilibrium <= _BALANCED
    told = f"the forces of the file balance a gravity of {np.linalg.norm(gravity):.4g} m/s2"
    if not balanced:
        told = "the forces of the file do not balance the weights of its blocks"
    elif pulls:
        told += ", with tension"
    stands = balanced and not pulls
    return (
        Result(
            "file", Verdict.EQUILIBRIUM_EXISTS if stands else Verdict.UNDECIDED, model, told,
            force=force, tension=tension if pulls else None, displacement=displacement,
            residuals=residuals,
        ),
    )  # fmt: skip
