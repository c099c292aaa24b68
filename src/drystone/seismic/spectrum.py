"""Response spectra in the shapes of Eurocode 8 and of the Italian code, and what a site asks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.files import PathLike, as_path, digest, read_bytes
from drystone.base.table import Table
from drystone.base.units import measured
from drystone.io.jsontext import Field, parse_toml, standard
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
        data = standard("seismic/standards/ec8")
        table = _known(data, f"type{kind}", "type")
        factor, *periods = _known(table, soil, "soil").floats(4).tolist()
        return cls(ground, factor, data["plateau"].number(), *periods)

    @classmethod
    def ntc(
        cls, ground: float, plateau: float, period: float, soil: str, topography: float = 1.0
    ) -> Spectrum:
        """The shape of the Italian code, from ag [m/s2], F0 and TC* [s] of the site."""
        data = standard("seismic/standards/ntc")
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

    def damped(self, percent: float) -> Spectrum:
        """With another damping [%]: eta = (10 / (5 + percent))^0.5, at least 0.55."""
        return replace(self, damping=max(math.sqrt(10.0 / (5.0 + percent)), 0.55))


@dataclass(frozen=True)
class LimitState(OneLine):
    """How an edition of the Italian Circolare verifies a mechanism at a limit state.

    Attributes
    ----------
    edition, name
        ``2009`` or ``2019``; ``SLD``, ``SLV`` or, of 2019, ``SLC``.
    behaviour
        Factor q of the linear verification where no other is given; 0 where there is none.
    ultimate
        The displacement that counts by d0*; 0 where there is no non-linear verification.
    secant, factor
        Ts = factor pi (d/a)^0.5, where d is ``secant`` times that displacement.
    damping : [%]
    """

    edition: str
    name: str
    behaviour: float
    ultimate: float
    secant: float
    factor: float
    damping: float

    @classmethod
    def named(cls, edition: str = "2019", name: str = "SLV") -> LimitState:
        """From the data of an edition."""
        row = _known(
            _known(standard("seismic/standards/kinematic")["states"], edition, "edition"),
            name,
            "state",
        )
        numbers = ("q", "ultimate", "secant", "factor", "damping")
        return cls(edition, name, *(row.get(one, 0.0).number() for one in numbers))


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
    state
        What is verified; by Circolare 7/2019 at SLV when left out.
    building_damping : [%]
        By which Circolare 7/2019 takes the acceleration of a storey.
    given
        What the site file says, by its keys, its name and its hash; empty where there is none.
    """

    spectrum: Spectrum
    behaviour: float = 2.0
    confidence: float = 1.0
    period: float = 0.0
    shape: float = 1.0
    participation: float = 1.0
    state: LimitState = field(default_factory=LimitState.named)
    building_damping: float = 5.0
    given: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def named(cls, path: PathLike) -> SeismicDemand:
        """From a TOML file.

        ``code`` (``ec8`` or ``ntc``), ``ag`` with its unit (``"0.15g"``), ``soil`` (A to E), ``q``,
        ``confidence`` (a number, or LC1 to LC3); ``type`` (ec8); ``F0``, ``TC_star`` [s] and
        ``topography`` (ntc); ``T1`` [s], ``psi`` and ``gamma`` of a part above the ground;
        ``edition`` of the Circolare (``"2019"`` with ``damping`` [%] of the building, or
        ``"2009"``) and ``state`` (SLV; SLD; SLC of 2019), to which ``ag`` belongs.

        Raises
        ------
        FormatError
            Something is missing, not known, or has no unit.
        """
        top = parse_toml(read_bytes(path), as_path(path))
        code = top.get("code", "not given")
        own = {"ec8": ("type",), "ntc": ("F0", "TC_star", "topography")}
        if code.text() not in own:
            raise code.error(f"is '{code.text()}'", "give ec8 or ntc")
        above = ("T1", "psi", "gamma")
        more = ("edition", "state", "q", "confidence", "damping")
        top.only(("code", "ag", "soil", *more, *above, *own[code.text()]))
        spectrum = _spectrum(top, code.text())
        given = [one for one in above if top.has(one)]
        if given and len(given) < len(above):
            raise top.error(f"has {given[0]}, not all of {', '.join(above)}", "give all three")
        edition = top.get("edition", "2019").text()
        with top.blamed():
            state = LimitState.named(edition, top.get("state", "SLV").text())
        behaviour = _behaviour(top, state)
        confidence = _confidence(top, edition)
        for one in (behaviour, confidence):
            if not 1.0 <= one.number() <= 1000.0:
                raise one.error(f"is {one.number():g}", "give 1 or more, up to 1000")
        period, shape, participation = [_positive(top[one]) for one in given] or (0.0, 1.0, 1.0)
        return cls(
            spectrum,
            behaviour.number(),
            confidence.number(),
            period,
            shape,
            participation,
            state,
            _positive(top.get("damping", 5.0)),
            {**top.value, "site file": as_path(path).name, "SHA-256 begins": digest(path)[:32]},
        )

    @property
    def verified(self) -> Spectrum:
        """With which displacements are compared: by Circolare 7/2019 of another damping."""
        plain = self.state.edition == "2009" or not self.state.ultimate
        return self.spectrum if plain else self.spectrum.damped(self.state.damping)

    def accelerations(self) -> dict[str, float]:
        """The least accelerations a0* [m/s2] of the linear verification, by their formulas."""
        if not self.state.behaviour:
            return {}
        asked = {"ag S / q": self.spectrum.ground * self.spectrum.soil / self.behaviour}
        if self.period and self.state.edition == "2009":
            top = self.spectrum.acceleration(self.period) * self.shape * self.participation
            asked["Se(T1) psi gamma / q"] = top / self.behaviour
        elif self.period:
            asked["aZ(z) / q"] = self._storey / self.behaviour
        return asked

    def displacements(self, period: float) -> dict[str, float]:
        """What displacement [m] is asked of a mechanism with a secant period [s]."""
        ground = self.verified
        asked = {"SDe(Ts)": ground.displacement(period)}
        if self.period and self.state.edition == "2009":
            ratio = period / self.period
            grown = ratio**2 / math.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio)
            top = self.spectrum.displacement(self.period) * self.shape * self.participation
            asked["SDe(T1) psi gamma (Ts/T1)^2 / ((1 - Ts/T1)^2 + 0.02 Ts/T1)^0.5"] = top * grown
        elif self.period:
            asked["SeZ(Ts) (Ts / 2 pi)^2"] = self._storey_displacement(ground, period)
        return asked

    @property
    def _storey(self) -> float:
        """The largest acceleration aZ [m/s2] of the storey, of the first mode.

        Source: Circolare 7/2019, eq. C7.2.7.
        """
        at = self.spectrum.damped(self.building_damping).acceleration(self.period)
        top = at * self.shape * self.participation
        return top * math.sqrt(1.0 + 0.0004 * self.building_damping**2)

    def _storey_displacement(self, ground: Spectrum, period: float) -> float:
        """The displacement [m] asked in a storey; it does not fall with the period.

        Source: Circolare 7/2019, eq. C7.2.5, C7.2.6 and C8.7.1.12, with the first mode. The damping
        in C7.2.6 is read as a share: as a percentage a storey would amplify nothing.
        """
        first, last = (
            standard("seismic/standards/kinematic")["storey"][one].number()
            for one in ("first", "last")
        )
        most = 1.1 * (0.01 * self.building_damping) ** -0.5 * ground.damping

        def at(one: float) -> float:
            ratio, less = one / self.period, 0.0
            if ratio < first:
                less = (1.0 - ratio / first) ** 1.6
            elif ratio >= last:
                less = (ratio / last - 1.0) ** 1.2
            level = most * self._storey / (1.0 + (most - 1.0) * less)
            if one > self.period:
                level = max(level, ground.acceleration(one))
            return level * (one / (2.0 * math.pi)) ** 2

        reached = at(period)
        return reached if period <= last * self.period else max(reached, at(last * self.period))

    def told(self) -> dict[str, float | str]:
        """Its numbers by name."""
        spectrum = {one.name: getattr(self.spectrum, one.name) for one in fields(Spectrum)}
        own = {one.name: getattr(self, one.name) for one in fields(SeismicDemand)[1:]}
        return {**spectrum, **own, "edition": self.state.edition, "state": self.state.name}

    def table(self) -> Table:
        """The spectrum, the factors and what is verified, as a calculation report lists them."""
        spectrum, state = self.spectrum, self.state
        taken = ", as no edition is given" if self.given and "edition" not in self.given else ""
        keys = ("code", "soil", "type", "TC_star", "topography", "site file", "SHA-256 begins")
        told = [(key, str(self.given[key])) for key in keys if key in self.given]
        told += [
            ("ground ag", f"{spectrum.ground:.4g} m/s2"),
            ("soil and topography S", f"{spectrum.soil:.4g}"),
            ("amplification F0", f"{spectrum.plateau:.4g}"),
            ("periods TB, TC, TD", ", ".join(
                f"{one:.3g}" for one in (spectrum.corner_b, spectrum.corner_c, spectrum.corner_d)
            ) + " s"),
            ("behaviour factor q", f"{self.behaviour:.4g}" if state.behaviour else "not counted"),
            ("confidence factor FC", f"{self.confidence:.4g}"),
            ("limit state", f"{state.name}, Circolare of {state.edition}{taken}"),
        ]  # fmt: skip
        if self.period:
            above = f"{self.period:.3g} s, {self.shape:.3g}, {self.participation:.3g}"
            told.append(("building T1, psi, gamma", above))
        names, texts = zip(*told, strict=True)
        return Table("site and limit state", {"of": list(names), "value": list(texts)})


def _known(table: Field, key: str, what: str) -> Field:
    if key not in table.value:
        names = ", ".join(name.removeprefix("type") for name in table.value if name != "plateau")
        raise InputError(f"{what} is '{key.removeprefix('type')}'", remedy=f"give one of {names}")
    return table[key]


def _spectrum(top: Field, code: str) -> Spectrum:
    """That of a site."""
    ground, soil = _acceleration(top["ag"]), top["soil"].text()
    with top.blamed():
        if code == "ec8":
            return Spectrum.ec8(ground, soil, top.get("type", 1).integer())
        shape, corner = _positive(top["F0"]), _positive(top["TC_star"])
        return Spectrum.ntc(ground, shape, corner, soil, _positive(top.get("topography", 1.0)))


def _behaviour(top: Field, state: LimitState) -> Field:
    """The factor q, which counts at SLV only."""
    if top.has("q") and state.name != "SLV":
        raise top["q"].error(f"is given, and {state.name} counts no q", "leave q out")
    return top.get("q", state.behaviour or 1.0)


def _confidence(top: Field, edition: str) -> Field:
    """The factor FC: a number, or a level of knowledge; that of the edition when left out."""
    data = standard("seismic/standards/kinematic")
    given = top.get("confidence", data["level"][edition].text())
    if not isinstance(given.value, str):
        return given
    with given.blamed():
        return _known(data["confidence"], given.text(), "level")


def _acceleration(one: Field) -> float:
    if not isinstance(one.value, str):
        raise one.error("has no unit", 'write "0.15g"')
    with one.blamed('write "0.15g"'):
        value = measured(one.value, {"g": STANDARD_GRAVITY}, what="ag")
    if not 0.0 < value <= 1e6:
        raise one.error(f"is {one.value}", "give more than zero")
    return value


def _positive(one: Field) -> float:
    if not 1e-6 <= one.number() <= 1e6:  # far beyond any building; its square is a number still
        raise one.error(f"is {one.number():g}", "give a number above zero, up to 1e6")
    return one.number()
