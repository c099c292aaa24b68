"""Response spectra in the shapes of Eurocode 8 and of the Italian code, and what a site asks."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from importlib import resources
from pathlib import Path

from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.files import PathLike, as_path, read_bytes
from drystone.base.units import measured
from drystone.io.jsontext import Field, parse_toml
from drystone.loads.case import STANDARD_GRAVITY


@dataclass(frozen=True)
class Spectrum(OneLine):
    """An elastic response spectrum, of 5 % damping unless ``damping`` is another.

    Attributes
    ----------
    ground : [m/s2]
        Peak acceleration ag on rock.
    soil
        Factor S of the ground, with the topography.
    plateau
        Amplification F0; 2.5 in Eurocode 8.
    corner_b, corner_c, corner_d : [s]
        Periods TB, TC and TD.
    damping
        Factor eta.

    Examples
    --------
    >>> spectrum = Spectrum.ec8(0.2 * 9.81, "B")
    >>> round(spectrum.acceleration(0.3), 3), round(spectrum.acceleration(1.0), 4)
    (5.886, 2.943)
    """

    ground: float
    soil: float
    plateau: float
    corner_b: float
    corner_c: float
    corner_d: float
    damping: float = 1.0

    @classmethod
    def ec8(cls, ground: float, soil: str, kind: int = 1) -> Spectrum:
        """The shape of EN 1998-1, type 1 or 2, on ground A to E, of ag [m/s2]."""
        data = _data("ec8")
        table = _known(data, f"type{kind}", "type")
        factor, *periods = _known(table, soil, "soil").floats(4).tolist()
        return cls(ground, factor, data["plateau"].number(), *periods)

    @classmethod
    def ntc(
        cls, ground: float, plateau: float, period: float, soil: str, topography: float = 1.0
    ) -> Spectrum:
        """The shape of the Italian code, from ag [m/s2], F0 and TC* [s] of the site."""
        data = _data("ntc")
        first, slope, least, most = _known(data["stratigraphic"], soil, "soil").floats(4).tolist()
        factor = min(max(first - slope * plateau * ground / STANDARD_GRAVITY, least), most)
        scale, power = data["period"][soil].floats(2).tolist()
        corner = scale * period**power * period
        last = 4.0 * ground / STANDARD_GRAVITY + 1.6
        return cls(ground, factor * topography, plateau, corner / 3.0, corner, last)

    def acceleration(self, period: float) -> float:
        """Se [m/s2] at a period [s]."""
        top = self.ground * self.soil * self.damping * self.plateau
        if period < self.corner_b:
            rise = period / self.corner_b
            return top * (rise + (1.0 - rise) / (self.damping * self.plateau))
        if period < self.corner_c:
            return top
        if period < self.corner_d:
            return top * self.corner_c / period
        return top * self.corner_c * self.corner_d / period**2

    def displacement(self, period: float) -> float:
        """SDe [m] at a period [s]."""
        return self.acceleration(period) * (period / (2.0 * math.pi)) ** 2


@dataclass(frozen=True)
class SeismicDemand(OneLine):
    """What an earthquake asks of a part of a building.

    Attributes
    ----------
    spectrum
    behaviour
        Factor q by which the acceleration is divided.
    confidence
        Factor FC by which the capacity is divided.
    period : [s]
        T1 of the building, where the part stands above the ground; 0 at the ground.
    shape
        Psi, the first mode at the height of the part.
    participation
        Gamma, the modal participation.
    """

    spectrum: Spectrum
    behaviour: float = 2.0
    confidence: float = 1.0
    period: float = 0.0
    shape: float = 1.0
    participation: float = 1.0

    @classmethod
    def named(cls, path: PathLike) -> SeismicDemand:
        """From a TOML file.

        ``code`` (``ec8`` or ``ntc``), ``ag`` with its unit (``"0.15g"``), ``soil`` (A to E), ``q``,
        ``confidence``; ``type`` (ec8); ``F0``, ``TC_star`` [s] and ``topography`` (ntc);
        ``T1`` [s], ``psi`` and ``gamma`` of a part above the ground.

        Raises
        ------
        FormatError
            Something is missing, not known, or has no unit.
        """
        top = parse_toml(read_bytes(path), as_path(path))
        code = top["code"]
        own = {"ec8": ("type",), "ntc": ("F0", "TC_star", "topography")}
        if code.text() not in own:
            raise code.error(f"is '{code.text()}'", "give ec8 or ntc")
        above = ("T1", "psi", "gamma")
        top.only(("code", "ag", "soil", "q", "confidence", *above, *own[code.text()]))
        ground, soil = _acceleration(top["ag"]), top["soil"].text()
        try:
            if code.text() == "ec8":
                spectrum = Spectrum.ec8(ground, soil, top.get("type", 1).integer())
            else:
                rise = top.get("topography", 1.0)
                spectrum = Spectrum.ntc(
                    ground, _positive(top["F0"]), _positive(top["TC_star"]), soil, _positive(rise)
                )
        except InputError as error:
            raise top.error(error.what, error.remedy) from error
        given = [one for one in above if top.has(one)]
        if given and len(given) < len(above):
            raise top.error(f"has {given[0]}, not all of {', '.join(above)}", "give all three")
        behaviour, confidence = top.get("q", 2.0), top.get("confidence", 1.0)
        for one in (behaviour, confidence):
            if one.number() < 1.0:
                raise one.error(f"is {one.number():g}", "give 1 or more")
        more = [_positive(top[one]) for one in given]
        return cls(spectrum, behaviour.number(), confidence.number(), *more)

    def accelerations(self) -> dict[str, float]:
        """The least accelerations a0* [m/s2] of the linear verification, by their formulas."""
        asked = {"ag S / q": self.spectrum.ground * self.spectrum.soil / self.behaviour}
        if self.period:
            top = self.spectrum.acceleration(self.period) * self.shape * self.participation
            asked["Se(T1) psi gamma / q"] = top / self.behaviour
        return asked

    def displacements(self, period: float) -> dict[str, float]:
        """What displacement [m] is asked of a mechanism with a secant period [s]."""
        asked = {"SDe(Ts)": self.spectrum.displacement(period)}
        if self.period:
            ratio = period / self.period
            grown = ratio**2 / math.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio)
            top = self.spectrum.displacement(self.period) * self.shape * self.participation
            asked["SDe(T1) psi gamma (Ts/T1)^2 / ((1 - Ts/T1)^2 + 0.02 Ts/T1)^0.5"] = top * grown
        return asked

    def told(self) -> dict[str, float]:
        """Its numbers by name."""
        spectrum = {one.name: getattr(self.spectrum, one.name) for one in fields(Spectrum)}
        own = {one.name: getattr(self, one.name) for one in fields(SeismicDemand)[1:]}
        return {**spectrum, **own}


def _data(name: str) -> Field:
    folder = resources.files("drystone.seismic").joinpath("standards")
    return parse_toml(folder.joinpath(f"{name}.toml").read_bytes(), Path(f"{name}.toml"))


def _known(table: Field, key: str, what: str) -> Field:
    if key not in table.value:
        names = ", ".join(name.removeprefix("type") for name in table.value if name != "plateau")
        raise InputError(f"{what} is '{key.removeprefix('type')}'", remedy=f"give one of {names}")
    return table[key]


def _acceleration(one: Field) -> float:
    if not isinstance(one.value, str):
        raise one.error("has no unit", 'write "0.15g"')
    try:
        value = measured(one.value, {"g": STANDARD_GRAVITY}, what="ag")
    except InputError as error:
        raise one.error(error.what, 'write "0.15g"') from error
    if value <= 0.0:
        raise one.error(f"is {one.value}", "give more than zero")
    return value


def _positive(one: Field) -> float:
    if one.number() <= 0.0:
        raise one.error(f"is {one.number():g}", "give a number above zero")
    return one.number()
