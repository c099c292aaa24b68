"""Presets: layers that are shown together under one name, on the page and on paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from drystone.answer.scene import Layer, Scene
from drystone.base.display import OneLine


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


_MARKS = frozenset({"hinges", "sliding", "help", "tension"})
_ASKED = frozenset({"missed", "missed-points", "defects", "lines", "opening"})

PRESETS: Mapping[str, Preset] = MappingProxyType(
    {
        "forces": Preset("Forces", _MARKS | {"joint-force", "network", "opening"}),
        "solid": Preset("Solid", _MARKS | {"opening"}, opacity=1.0, ghost=True),
        "contacts": Preset("Contacts", _ASKED | {"interfaces"}, opacity=0.3),
        "utilisation": Preset("Utilisation", frozenset({"joint-use", "sliding"})),
        "stages": Preset("Stages", frozenset({"help"}), opacity=1.0, numbers=True, ghost=True),
    }
)
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
