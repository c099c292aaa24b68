"""Colours of the pictures, by role.

The hues are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the
common colour deficiencies can tell apart; roles also differ in lightness or in shape.
"""

from __future__ import annotations

import enum

import numpy as np

from drystone.arrays import Floats


class State(enum.IntEnum):
    """What a block is in a stage; its colour."""

    ABSENT = 0
    """Not placed yet: not drawn."""
    FREE = 1
    SUPPORT = 2
    FALLING = 3
    HELD = 4
    PROPPED = 5


STATE_LABEL = {
    State.FREE: "free block",
    State.SUPPORT: "support",
    State.FALLING: "falls",
    State.HELD: "held while it is placed",
    State.PROPPED: "propped",
}

STATE_COLOUR = {
    "light": {
        State.FREE: "#d9d5cb",
        State.SUPPORT: "#56b4e9",
        State.FALLING: "#cc79a7",
        State.HELD: "#7a7a7a",
        State.PROPPED: "#1c1c1c",
    },
    "dark": {
        State.FREE: "#b5b1a7",
        State.SUPPORT: "#56b4e9",
        State.FALLING: "#cc79a7",
        State.HELD: "#6a6a6a",
        State.PROPPED: "#202020",
    },
}

ROLE_COLOUR = {
    "light": {
        "background": "#ffffff",
        "edge": "#2e2b26",
        "selection": "#f0e442",
        "interface": "#f0e442",
        "pressure": "#0072b2",
        "tension": "#d55e00",
        "resultant": "#009e73",
        "missed": "#e69f00",
    },
    "dark": {
        "background": "#14171b",
        "edge": "#101215",
        "selection": "#f0e442",
        "interface": "#f0e442",
        "pressure": "#2b93d6",
        "tension": "#f07a1a",
        "resultant": "#00b386",
        "missed": "#e69f00",
    },
}


def rgb(colour: str) -> Floats:
    """(3,) components from 0 to 1 of a ``#rrggbb`` colour."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
