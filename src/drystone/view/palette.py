"""Colours of the pictures, by role.

The hues are those of Okabe and Ito (Color Universal Design, 2008), which people with any of the
common colour deficiencies can tell apart; roles also differ in lightness or in shape. The scale of
forces is one hue whose lightness changes evenly, so that equal steps of force look equally large.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drystone.answer.scene import Layer, Scene, State
from drystone.base.arrays import Floats
from drystone.base.display import OneLine

_THEMES = ("light", "dark")

_STATES = {
    State.FREE: ("free block", "#d9d5cb", "#b5b1a7"),
    State.SUPPORT: ("support", "#566070", "#66717f"),
    State.FALLING: ("falls", "#cc79a7", "#cc79a7"),
    State.HELD: ("held while it is placed", "#e69f00", "#e69f00"),
    State.PROPPED: ("propped", "#d55e00", "#d55e00"),
    State.LATER: ("propped later", "#d9d5cb", "#b5b1a7"),
    State.COMING: ("placed now", "#56b4e9", "#56b4e9"),
    State.ADDED: ("added", "#d55e00", "#d55e00"),
}
"""Words for each state, and its colours by theme."""

STATE_LABEL = {state: words for state, (words, *_) in _STATES.items()}
STATE_COLOUR = {
    theme: {state: colours[i] for state, (_, *colours) in _STATES.items()}
    for i, theme in enumerate(_THEMES)
}

_ROLES = {
    "background": ("#ffffff", "#14171b"),
    "edge": ("#2e2b26", "#c9c5bc"),
    "cut": ("#736e66", "#9e998f"),
    "selection": ("#f0e442", "#f0e442"),
    "interface": ("#0072b2", "#56b4e9"),
    "pressure": ("#0072b2", "#56b4e9"),
    "network": ("#00734f", "#35d6a4"),
    "resultant": ("#009e73", "#35d6a4"),
    "hinge": ("#56b4e9", "#56b4e9"),
    "help": ("#c8102e", "#ff5c66"),
    "missed": ("#e69f00", "#e69f00"),
    "added": ("#d55e00", "#d55e00"),
    "kern": ("#cc79a7", "#e3a3c6"),
    "load": ("#1d1b18", "#eceae5"),
    "reaction": ("#46566b", "#a9bad0"),
}
"""Colours of each role by theme."""

ROLE_COLOUR = {
    theme: {role: one[i] for role, one in _ROLES.items()} for i, theme in enumerate(_THEMES)
}


def ramp(lightness: tuple[float, float], hue_deg: float, chroma: float, steps: int = 17) -> Floats:
    """(steps, 3) sRGB components of a scale whose lightness changes evenly, ends almost grey.

    Source: Ottosson 2020, A perceptual color space for image processing (Oklab).
    """
    share = np.linspace(0.0, 1.0, steps)
    level = lightness[0] + (lightness[1] - lightness[0]) * share
    strength = chroma * np.sin(np.pi * np.clip(share, 0.0, 0.85)) ** 0.8
    hue = np.deg2rad(hue_deg)
    a, b = strength * np.cos(hue), strength * np.sin(hue)
    cone = np.stack([
        level + 0.3963377774 * a + 0.2158037573 * b,
        level - 0.1055613458 * a - 0.0638541728 * b,
        level - 0.0894841775 * a - 1.2914855480 * b,
    ]) ** 3  # fmt: skip
    linear = np.array([
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]) @ cone  # fmt: skip
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055).T


FORCE_RAMP = {"light": ramp((1.0, 0.29), 255.0, 0.17), "dark": ramp((0.36, 0.97), 240.0, 0.12)}
"""Colours of forces from zero to the largest: white to dark blue on paper, dark grey to almost
white on a dark page."""


def rgb(colour: str) -> Floats:
    """(3,) components from 0 to 1 of a ``#rrggbb`` colour."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def hexadecimal(colour: Floats) -> str:
    """``#rrggbb`` of (3,) components from 0 to 1."""
    return "#" + "".join(f"{round(255.0 * float(part)):02x}" for part in colour)


def ramp_colours(share: Floats, theme: str = "light") -> Floats:
    """Colours (p, 3) of shares (p,) of the largest force."""
    stops = FORCE_RAMP[theme]
    at = np.clip(share, 0.0, 1.0) * (len(stops) - 1)
    position = np.arange(len(stops))
    return np.stack([np.interp(at, position, stops[:, i]) for i in range(3)], axis=-1)


@dataclass(frozen=True)
class Preset(OneLine):
    """A picture with a name.

    Attributes
    ----------
    label
    layers
        Keys of the layers that are shown.
    opacity
        Of the blocks.
    numbers
        Whether blocks carry their numbers.
    ghost
        Whether outlines show the start or the end of the motion.
    """

    label: str
    layers: frozenset[str]
    opacity: float = 0.22
    numbers: bool = False
    ghost: bool = False


_LOADS = frozenset({"loads", "moments", "surface", "acceleration"})
_MARKS = _LOADS | {"hinges", "sliding", "help", "tension"}
_ASKED = _LOADS | {"missed", "missed-points", "defects", "lines", "opening"}

PRESETS: Mapping[str, Preset] = {
    "forces": Preset(
        "Forces", _MARKS | {"edges", "spent", "joint-force", "network", "opening", "reactions"}
    ),
    "solid": Preset("Solid", _MARKS - {"tension"} | {"opening"}, opacity=1.0, ghost=True),
    "contacts": Preset("Contacts", _ASKED | {"interfaces"}, opacity=0.3),
    "utilisation": Preset("Utilisation", frozenset({"joint-use", "spent"})),
    "stages": Preset("Stages", frozenset({"help"}), opacity=1.0, numbers=True, ghost=True),
}
"""Pictures by key."""

KNOWN = frozenset(
    {"joint-pressure", "pressure", "resultants"}.union(*(one.layers for one in PRESETS.values()))
)
"""Layers that presets switch."""


def first_preset(scene: Scene, stage: int = 0) -> str:
    """The first preset of a stage of a scene: forces, if it has some."""
    if scene.preset:
        return scene.preset
    keys = {layer.key for layer in scene.stages[stage].layers}
    if "network" in keys:
        return "forces"
    if scene.stages[stage].motion is not None:
        return "solid"
    return "contacts"


def is_shown(layer: Layer, preset: str) -> bool:
    """Whether a preset shows a layer; a layer in no preset has its own default."""
    return layer.key in PRESETS[preset].layers or (layer.key not in KNOWN and layer.visible)
