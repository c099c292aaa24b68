"""What an earthquake shakes: blocks, and the masses that they carry; no forces.

Source: EN 1998-1, 3.2.4, and NTC 2018, 2.5.3: the masses of all gravity loads. By d'Alembert the
force of each acts at its place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.base.units import quantity
from drystone.loads.applied import applied_loads
from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase
from drystone.loads.masses import CarriedMass

_KINDS = {"mass": "masses in kg", "load": "loads"}


@dataclass(frozen=True, eq=False)
class Shaken(OneLine):
    """What an earthquake shakes.

    Attributes
    ----------
    weights : [N]
        By kind: blocks, fill, resisting fill, masses in kg, loads.
    still : [N]
        Downward forces that are not shaken.
    """

    weights: Mapping[str, float]
    still: float

    def _summary(self) -> str:
        return self.words

    @classmethod
    def of(cls, assembly: Assembly, load: LoadCase, blocks: Bools | None = None) -> Shaken | None:
        """That of a load case, on some free blocks (n,); ``None`` without an earthquake.

        Examples
        --------
        >>> from drystone.models import tower
        >>> few = tower(2)
        >>> load = LoadCase.gravity(few) + LoadCase.extra_mass(few, 1, 1000.0)
        >>> print(Shaken.of(few, load + LoadCase.seismic(few, 0.1)).words)
        the earthquake shakes 33.4 kN: 23.5 kN of blocks and 9.81 kN of masses in kg
        """
        if not load.shake.any():
            return None
        free = ~assembly.fixed if blocks is None else blocks & ~assembly.fixed
        weights = {"blocks": STANDARD_GRAVITY * float(assembly.mass[free].sum())}
        for one in load.masses:
            name = _KINDS.get(one.kind, one.kind)
            weights[name] = weights.get(name, 0.0) + STANDARD_GRAVITY * float(one.mass[free].sum())
        applied = applied_loads(assembly, load.beside_masses)
        down = -np.minimum(applied.force[free[applied.block], 2], 0.0).sum()
        still = float(down) if down > 1e-6 * sum(weights.values()) else 0.0
        return cls({name: one for name, one in weights.items() if one}, still)

    @property
    def words(self) -> str:
        """What is shaken, and what is not."""
        parts = [f"{quantity(one, 'N')} of {name}" for name, one in self.weights.items()]
        total = quantity(sum(self.weights.values()), "N")
        told = f"{total}: {', '.join(parts[:-1])} and {parts[-1]}" if parts[1:] else "".join(parts)
        more = f"; {quantity(self.still, 'N')} of forces are not (--shaken)" if self.still else ""
        if "resisting fill" in self.weights:
            more += "; passive pressure is taken as the static one (Mononobe-Okabe's is less)"
        return f"the earthquake shakes {told}{more}"


def with_shaken_weights(
    assembly: Assembly,
    load: LoadCase,
    g: float = STANDARD_GRAVITY,
    common: Floats | None = None,
) -> LoadCase:
    """A load case whose downward forces are weights of masses, where their lines enter blocks.

    Their masses are those by a gravity ``g`` [m/s2]. What is not shaken is ``common`` (3,) [m/s2],
    :func:`common_acceleration` when left out.

    Examples
    --------
    >>> from drystone.models import tower
    >>> few = tower(2)
    >>> roof = LoadCase.point_load(few, 1, (0.0, 0.0, -981.0))
    >>> with_shaken_weights(few, roof).masses
    (CarriedMass(load, 100 kg),)
    """
    applied = applied_loads(assembly, load.beside_masses, common)
    down = applied.force[:, 2] < 0.0
    if not down.any():
        return load
    mass = -applied.force[down, 2] / g
    gravity: Floats = g * np.array(DOWN)
    made = CarriedMass.at(assembly, "load", applied.block[down], mass, applied.point[down], gravity)
    made = made.shaken(load.shake)
    wrench = load.wrench + made.pushed(load.shake)
    left = np.ones((len(assembly), 1, 3))
    left[applied.block[down], :, 2] = 0.0
    given = None if load.given is None else load.given * left
    return replace(load, wrench=wrench, masses=(*load.masses, made), given=given)
