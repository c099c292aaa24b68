"""The bridge of Kao 2023, section 7.2.4: blocks that hook into each other over two abutments.

Sections (x, z) [m] in a vertical plane, to a micrometre, extruded along y. The left half mirrors
the right one. Source of the figures: Kao 2023, doctoral dissertation, ETH Zurich, and the public
samples of compas_cra (Block Research Group). The openings in its abutments are left out: the
abutments are fixed.
"""

from __future__ import annotations

import numpy as np

from drystone.assembly import DEFAULT_DENSITY, Assembly, Block
from drystone.models.solids import prism

DEPTH = 0.5
"""[m], of every block along y."""

LOAD_DENSITY = 3.51
"""Density of the load by that of the bridge, as in the source."""

# fmt: off
RIGHT = {
    0: [
        (1.969301, 1.653149), (1.933333, 1.55), (2.1, 1.55), (1.96565, 1.45305), (2.1, 1.05),
        (1.972487, 1.108852), (1.980973, -3.9e-05), (2.356418, -0.000523), (2.234035, 1.653149),
    ],
    2: [
        (1.367736, 1.46039), (1.202294, 1.416913), (1.396638, 1.393697), (1.972487, 1.108852),
        (2.1, 1.05), (2.05, 1.2), (1.478455, 1.45305), (1.44714, 1.45305), (1.402102, 1.488625),
    ],
    4: [
        (0.964604, 1.55), (0.95, 1.504409), (1.22205, 1.492305), (1.367736, 1.46039),
        (1.402102, 1.488625), (1.44714, 1.45305), (1.96565, 1.45305), (2.1, 1.55),
    ],
    6: [
        (1.202294, 1.416913), (1.367736, 1.46039), (1.22205, 1.492305), (0.95, 1.504409),
        (0.964604, 1.55), (0.895676, 1.55), (0.886952, 1.505269), (0.539017, 1.510014),
        (0.530598, 1.471482),
    ],
    9: [
        (0.539017, 1.510014), (0.886952, 1.505269), (0.895676, 1.55), (0.25597, 1.55),
        (0.250894, 1.517356),
    ],
}
"""Sections of the blocks on the right, by their number; their mirror images have the next one."""

KEYSTONE = [
    (-0.25597, 1.55), (-0.250894, 1.517356), (-0.539017, 1.510014), (-0.530598, 1.471482),
    (0.0, 1.5), (0.530598, 1.471482), (0.539017, 1.510014), (0.250894, 1.517356), (0.25597, 1.55),
]

LOAD = {
    11: (1.258888, 1.595730, 1.792155),
    12: (0.452731, 0.789573, 1.851188),
    13: (-0.175202, 0.175202, 2.167770),
}
# fmt: on
"""Extent along x, and top, of the boxes on the deck in figure 7.4."""

DECK = 1.55
"""[m], height of the deck."""


def bridge(*, load: bool = False) -> Assembly:
    """A bridge of nine blocks between two abutments, which is built without centring.

    Under self-weight alone every block can be placed without help at a friction coefficient of
    0.35, and none at 0.34 (Kao 2023, section 7.2.4).

    Parameters
    ----------
    load
        Whether five boxes stand on the deck, 3.51 times as dense as the bridge (figure 7.4).

    Returns
    -------
    Assembly
        ``abutment-0`` and ``abutment-1``, fixed, ``block-2`` to ``block-10``, of which 8 is the
        keystone, and ``load-11`` to ``load-15``: their numbers are their positions.

    Examples
    --------
    >>> assembly = bridge()
    >>> len(assembly), assembly.names[8]
    (11, 'block-8')
    """
    span = (0.0, DEPTH)
    made: dict[int, Block] = {}
    for number, corners in RIGHT.items():
        kind = "block" if number else "abutment"
        mirrored = [(-x, z) for x, z in corners]
        made[number] = prism(corners, span, f"{kind}-{number}")
        made[number + 1] = prism(mirrored, span, f"{kind}-{number + 1}")
    made[8] = prism(KEYSTONE, span, "block-8")
    if load:
        for number, (left, right, top) in LOAD.items():
            box = np.array([(left, DECK), (right, DECK), (right, top), (left, top)])
            for name, side in ((number, 1.0), (26 - number, -1.0)):
                density = LOAD_DENSITY * DEFAULT_DENSITY
                made[name] = prism(box * (side, 1.0), span, f"load-{name}", density)
    blocks = tuple(made[number] for number in sorted(made))
    return Assembly(blocks, np.arange(len(blocks)) < 2)
