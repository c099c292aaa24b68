"""Parts of a diagnosis, and of a mend, as text."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drystone.base.arrays import Floats
from drystone.base.display import rounded_up
from drystone.base.units import quantity
from drystone.model import Model
from drystone.results import Result

NAMED = 4
"""Number of blocks of a region that are named. Chosen. The others are counted."""

_UPRIGHT = 0.1
"""A joint is neither upper nor lower if the vertical component of its normal is below this: 6
degrees."""

_ALONG = 0.995
"""A direction is that of an axis if its component along it is larger: 6 degrees."""


def force_words(force: Floats) -> str:
    """A force (3,) [N] as text, with its direction.

    Examples
    --------
    >>> import numpy as np
    >>> force_words(np.array([0.0, 0.0, 20.0])), force_words(np.array([-3e3, 0.0, 4e3]))
    ('20 N (up)', '5 kN (53 degrees above level towards -x)')
    >>> force_words(np.array([3.0, 4.0, 0.0])), force_words(np.zeros(3))
    ('5 N (level towards (0.6, 0.8))', '0 N')
    """
    size = math.hypot(*force)
    if abs(force[2]) >= _ALONG * size:
        return quantity(size, "N") + (f" ({'up' if force[2] > 0.0 else 'down'})" if size else "")
    level = f"level towards {towards(force)}"
    steep = round(math.degrees(math.asin(force[2] / size)))
    slope = f"{abs(steep)} degrees {'above' if steep > 0 else 'below'} " if steep else ""
    return f"{quantity(size, 'N')} ({slope}{level})"


def towards(way: Floats) -> str:
    """The level part of a direction (3,) as text; that along z where it has none.

    Examples
    --------
    >>> import numpy as np
    >>> towards(np.array([0.0, -2.0, 1.0])), towards(np.array([0.0, 0.0, -1.0]))
    ('-y', '-z')
    """
    if abs(way[2]) >= _ALONG * math.hypot(*way):
        return "+z" if way[2] > 0.0 else "-z"
    plan = way[:2] / math.hypot(*way[:2])
    axes = [a for a, x in zip(("+x", "+y", "-x", "-y"), (*plan, *-plan), strict=True) if x > _ALONG]
    return axes[0] if axes else place(plan).removesuffix(" m")


def glue_words(
    model: Model, interfaces: Sequence[int], strength: float, *, whole: bool = True, name: str = ""
) -> str:
    """Glue in some joints as text, with its strength [N] rounded up.

    Without ``whole`` blocks are not named: the sentence has their names already. ``name`` is that
    of joints that are alike.
    """
    ends = {(int(model.contacts.block_a[k]), int(model.contacts.block_b[k])) for k in interfaces}
    where = f" between {names_of(model, ends.pop()) if whole else 'them'}" if len(ends) == 1 else ""
    carried = f"a pull, and a shear, of {quantity(rounded_up(strength, 3), 'N')}"
    if name:
        return f"glue or pegs in {name}, each of which carries {carried}"
    if len(interfaces) == 1:
        return f"glue{where} that carries {carried}"
    count = f"{len(interfaces)} joints"
    which = f"{count}{where}" if where else f"the {count} that pull"
    return f"glue in {which}, each of which carries {carried}"


def friction_words(where: str, value: float) -> str:
    """A friction coefficient as text, rounded up to hundredths."""
    return f"friction of {math.ceil(100.0 * value - 1e-6) / 100.0:.2f} {where}".rstrip(",")


def place(point: Floats) -> str:
    """A point [m] as text, to a millimetre."""
    return "(" + ", ".join(f"{round(float(x), 3) + 0.0:g}" for x in point) + ") m"


def names_of(model: Model, blocks: Sequence[int]) -> str:
    """Names of blocks in a sentence."""
    named = [f"'{model.assembly.names[i]}'" for i in blocks]
    if len(named) > NAMED:
        named = [*named[: NAMED - 1], f"{len(named) - NAMED + 1} more"]
    return listed(named)


def listed(parts: Sequence[str]) -> str:
    """Parts of a sentence, one after the other.

    Examples
    --------
    >>> listed(["a"]), listed(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    *first, last = parts
    return f"{', '.join(first)} and {last}" if first else last


def joint_name(model: Model, blocks: Sequence[int], interface: int, *, whole: bool = False) -> str:
    """A joint of some blocks as text: lower, upper, upright or inner, and the other block.

    ``whole``: with the name of its own block, where the sentence does not have it already.
    """
    contacts = model.contacts
    a, b = int(contacts.block_a[interface]), int(contacts.block_b[interface])
    if a in blocks and b in blocks:
        return f"the joint of {names_of(model, [a, b])}"
    own, other = (a, b) if a in blocks else (b, a)
    of = f" of {names_of(model, [own])}" if whole else ""
    if abs(contacts.frame[interface, 0, 2]) < _UPRIGHT:
        return f"the joint{of} with {names_of(model, [other])}"
    above = contacts.centroid[interface][2] > model.assembly.centroid[own][2]
    which = f"the {'upper' if above else 'lower'} joint"
    return f"{which}{of}, with {names_of(model, [other])},"


NOTHING = "it stands: nothing is missing"


def nothing(result: Result) -> str:
    """The sentence if no region was found."""
    settles = "as its joints lie no block needs help: how they settle decides"
    return NOTHING if result.stable else settles


def friction_of_all(value: float, said: Sequence[float | None]) -> str:
    """The friction with which the whole model stands, as text.

    ``said`` are the coefficients of the regions, of which the sentences before told.
    """
    if len(said) == 1 and said[0] is not None and value == said[0]:
        return "the same friction in all joints would hold the whole model"
    return f"{friction_words('in all joints', value)} would hold the whole model"
