"""MJCF, the model format of MuJoCo: one file, meshes inside.

Source of the format: MuJoCo documentation, XML reference.
"""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from drystone.base.arrays import Floats, number
from drystone.base.errors import InputError
from drystone.base.files import PathLike, write_text
from drystone.io.draft import Contents
from drystone.io.simulator_bodies import bodies, gravity_of, model_of
from drystone.model import Model

_TIME_STEP = 0.001
"""[s], chosen: contacts are stiff, and a block of 0.1 m falls over in a tenth of a second."""


def mjcf_text(model: Model, *, name: str = "drystone", contact_s: float = 0.02) -> str:
    """A model as MJCF.

    Fixed blocks are fixed to the world, free ones have a free joint, each with a mesh for every
    convex piece. None begins inside another; a comment in the file says how deep they were drawn in
    each other. The smallest friction coefficient of the model is used for all joints, since
    MuJoCo has one per body. Contacts have several points (multiccd). MuJoCo's options against creep
    (impratio, noslip) are not used: with them stable vaults flew apart.

    Parameters
    ----------
    model
        Its load is one acceleration of all masses.
    name
        Name of the model.
    contact_s : [s]
        Time constant of contacts; MuJoCo's own when left out. With a smaller value blocks creep
        less. But a statue of 399 blocks flew apart with 0.01, since its contacts were too stiff for
        the time step, and some large vaults did below 0.005.

    Raises
    ------
    InputError
        The load differs from block to block, or ``contact_s`` is not above zero.

    Examples
    --------
    >>> from drystone.models import tower
    >>> text = mjcf_text(Model.of(tower(2), friction=0.7))
    >>> text.count("<body"), text.count("<freejoint")
    (2, 1)
    """
    if not number(contact_s, "contact_s") > 0.0:
        raise InputError(f"contact_s is {contact_s}", remedy="give seconds above zero")
    found, said = bodies(model)
    friction = float(model.contacts.friction.min(initial=np.inf))
    friction = friction if np.isfinite(friction) else 0.6
    lines = [
        f"<mujoco model={quoteattr(name)}>",
        *([f"  <!-- {said} -->"] if said else []),
        f'  <option timestep="{_TIME_STEP:g}" gravity="{_numbers(gravity_of(model))}" '
        'cone="elliptic" solver="Newton" iterations="100" tolerance="1e-12">',
        '    <flag multiccd="enable"/>',
        "  </option>",
        '  <compiler inertiafromgeom="false" balanceinertia="true"/>',
        "  <default>",
        f'    <geom type="mesh" condim="3" friction="{friction:g} 0 0" solref="{contact_s:g} 1" '
        'solimp="0.99 0.999 0.0001" rgba="0.85 0.83 0.79 1"/>',
        "  </default>",
        "  <asset>",
    ]
    for body in found:
        for k, (point, _) in enumerate(body.pieces):
            mesh = quoteattr(f"{body.name}.{k}")
            lines.append(f'    <mesh name={mesh} vertex="{_numbers(point.ravel())}"/>')
    lines += ["  </asset>", "  <worldbody>", '    <light pos="0 0 20" dir="0 0 -1"/>']
    for body in found:
        lines.append(f'    <body name={quoteattr(body.name)} pos="{_numbers(body.place)}">')
        if not body.fixed:
            lines.append("      <freejoint/>")
        inertia = body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        lines.append(
            f'      <inertial pos="0 0 0" mass="{body.mass:.12g}" '
            f'fullinertia="{_numbers(inertia)}"/>'
        )
        for k in range(len(body.pieces)):
            colour = ' rgba="0.34 0.71 0.91 1"' if body.fixed else ""
            lines.append(f"      <geom mesh={quoteattr(f'{body.name}.{k}')}{colour}/>")
        lines.append("    </body>")
    lines += ["  </worldbody>", "</mujoco>", ""]
    return "\n".join(lines)


def write(contents: Contents, path: Path) -> None:
    """Write what a file holds as MJCF."""
    write_mjcf(model_of(contents), path)


def write_mjcf(
    model: Model, path: PathLike, *, name: str = "drystone", contact_s: float = 0.02
) -> None:
    """Write a model as MJCF, to a temporary name beside it that is then renamed.

    Parameters
    ----------
    model, name, contact_s
        See :func:`mjcf_text`.
    path
    """
    write_text(path, mjcf_text(model, name=name, contact_s=contact_s))


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.9g}" for value in values.tolist())
