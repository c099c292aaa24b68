"""Trains that move over a bridge, axles and a line load: of a small library, or one's own TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Self

import numpy as np

from drystone.base.arrays import Floats, frozen_floats
from drystone.base.errors import InputError, counted, located, meant
from drystone.base.files import read_bytes, shipped, toml_of
from drystone.base.settings import Options
from drystone.base.units import UNITS, measured, quantity
from drystone.loads.fill import Tops
from drystone.loads.ground_words import before, force


def _line_load(text: str) -> float:
    """A load by length [N/m]."""
    return force(before(text, "m", "line = '80kN/m', on all of the lane"))


def _length(text: str) -> float:
    """A length [m], with its unit."""
    return measured(text, UNITS, what="length")


_READ = dict.fromkeys(("contact", "across", "lane", "clear"), _length) | {"line": _line_load}
_KEYS = ("source", "axles", *_READ)


@dataclass(frozen=True)
class Train(Options):
    """Axles at fixed distances, and a line load where it is adverse.

    Attributes
    ----------
    name
    places : (a,) [m]
        From the first axle on.
    loads : (a,) [N]
    contact, across : [m] >= 0, <= 1000
        Length and width of the road on which an axle acts; over the whole width of the bridge
        where ``across`` is zero.
    line : [N/m] >= 0, <= 1e9
        Load by length on any parts of the road; none at zero.
    lane : [m] >= 0, <= 1000
        Width on which the line load acts; the whole width of the bridge at zero.
    clear : [m] >= 0, <= 1000
        Between the line load and the first and the last axle; it acts between axles as well when
        left out.
    source

    Examples
    --------
    >>> Train.named("lm1").length
    1.2
    """

    name: str
    places: tuple[float, ...]
    loads: tuple[float, ...]
    contact: float = 0.0
    across: float = 0.0
    line: float = 0.0
    lane: float = 0.0
    clear: float | None = None
    source: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        where = f"train '{self.name}'"
        for name in ("places", "loads"):
            given = frozen_floats(getattr(self, name), (None,), name)
            object.__setattr__(self, name, tuple(given.tolist()))
        if not self.places or len(self.places) != len(self.loads):
            axles = f"{len(self.places)} places and {counted(len(self.loads), 'load')}"
            raise InputError(axles, where=where, remedy="give a load for each axle")
        if min(self.loads) <= 0.0 or list(self.places) != sorted(self.places):
            raise InputError(
                "a load is not above zero, or its places do not grow", where=where,
                remedy="list axles from the first one on",
            )  # fmt: skip
        if not self.line and (self.lane or self.clear is not None):
            raise InputError(
                "it has no line load, but a lane or what is clear of one", where=where,
                remedy="give line, such as 27kN/m",
            )  # fmt: skip
        if self.places[0] != 0.0:
            raise InputError("its first axle is not at 0 m", where=where, remedy="count from it")

    def _summary(self) -> str:
        return f"'{self.name}', {counted(len(self.places), 'axle')}, {sum(self.loads):.4g} N"

    @property
    def length(self) -> float:
        """[m], from the first axle to the last one."""
        return self.places[-1]

    @property
    def words(self) -> str:
        """Its axles, and on what they act.

        Examples
        --------
        >>> Train.named("lm1-axle").words
        'axles of 300 kN at 0 m, each on 0.4 m along x and a width of 2.4 m'
        >>> Train.named("lm1").words.partition("; ")[2]
        '27 kN/m along x on a width of 3 m, where it is adverse'
        """
        each = zip(self.loads, self.places, strict=True)
        axles = ", ".join(f"{quantity(load, 'N')} at {place:g} m" for load, place in each)
        wide, lane = (f"{x:g} m" if x else "the whole bridge" for x in (self.across, self.lane))
        told = f"axles of {axles}, each on {self.contact:g} m along x and a width of {wide}"
        if not self.line:
            return told
        told += f"; {quantity(self.line, 'N/m')} along x on a width of {lane}, where it is adverse"
        return told if self.clear is None else f"{told} from {self.clear:g} m beside the axles on"

    @property
    def turned(self) -> Train:
        """The same train that moves the other way."""
        places = tuple(self.places[-1] - one for one in reversed(self.places))
        return replace(self, places=places, loads=self.loads[::-1])

    @property
    def ways(self) -> tuple[Train, ...]:
        """Itself and what it is turned round; one where both are alike."""
        other = self.turned
        pairs = zip((*self.places, *self.loads), (*other.places, *other.loads), strict=True)
        alike = all(abs(a - b) <= 1e-9 * max(abs(a), abs(b)) for a, b in pairs)
        return (self,) if alike else (self, other)

    @classmethod
    def named(cls, text: str) -> Self:
        """Of the library by its name, or of a TOML file.

        Raises
        ------
        InputError
            There is none, or the file cannot be read.
        """
        if text.lower().endswith(".toml"):
            return cls._of(Path(text).stem, toml_of(read_bytes(text), text), text)
        known = _library()
        if text not in known:
            others = meant(text, list(known), f"use {', '.join(known)} or a .toml")
            raise InputError(f"there is no train '{text}'", remedy=others)
        return cls._of(text, known[text], f"train '{text}'")

    @classmethod
    def _of(cls, name: str, found: Mapping[str, Any], where: str) -> Self:
        odd = [key for key in found if key not in _KEYS]
        axles = found.get("axles")
        if odd or not isinstance(axles, list):
            what = f"'{odd[0]}' is no key" if odd else "it has no axles"
            raise InputError(what, where=where, remedy=f"give {', '.join(_KEYS)}")
        loads, places = _axles(axles, where)
        with located(where):
            known = {key: read(str(found[key])) for key, read in _READ.items() if key in found}
            return cls(name, places, loads, source=str(found.get("source", "")), **known)

    def on(self, tops: Tops, middle: Floats) -> Floats:
        """Wrenches (p, n, 6) of its axles on a bridge, its middle at places (p,) [m] along it."""
        first = middle - 0.5 * self.length
        each = zip(self.places, self.loads, strict=True)
        apart = (tops.spread(load, first + x, self.contact, self.across) for x, load in each)
        return np.asarray(sum(apart))

    def pieces(self, tops: Tops, middle: float) -> tuple[Floats, Floats]:
        """Pieces of the road that the line load may act on, its middle at a place [m] along it.

        Returns
        -------
        ends : (p, 2) [m]
        wrenches : (p, n, 6)
            Of the line load on each piece alone. Pieces are a 48th of the bridge at most: where it
            ceases to be adverse, its work is nearly zero.
        """
        if not self.line:
            return np.zeros((0, 2)), np.zeros((0, len(tops.road.assembly), 6))
        low, high = tops.road.ends
        reach = tops.fill.spread * tops.road.depth(np.array([low, high])).max()
        cuts = np.linspace(low - reach, high + reach, 49)
        free = np.zeros(48, dtype=bool)
        if self.clear is not None:
            away = 0.5 * self.length + self.clear
            cuts = np.union1d(cuts, np.clip([middle - away, middle + away], cuts[0], cuts[-1]))
            free = np.abs(0.5 * (cuts[1:] + cuts[:-1]) - middle) < away
        ends = np.stack([cuts[:-1], cuts[1:]], axis=1)[~free]
        return ends, tops.pieces(self.line, self.lane, ends)


def _axles(texts: Sequence[Any], where: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Loads [N] and places [m] of axles such as ``300kN at 1.2m``."""
    each = [str(one).partition(" at ") for one in texts]
    with located(where, "write '300kN at 1.2m'"):
        for load, at, _ in each:
            if not at:
                raise InputError(f"axle '{load}' has no place")
        return tuple(force(one[0]) for one in each), tuple(_length(one[2]) for one in each)


@cache
def _library() -> Mapping[str, Mapping[str, Any]]:
    return tomllib.loads(shipped("loads/trains.toml"))
