"""Bridges with fill under an axle, against a plane linear program that shares nothing with ours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import linprog

from drystone import InputError, Model, check
from drystone.limits import LimitOptions, TrainEnvelope, limit_load, limit_train
from drystone.loads import Fill, Train
from drystone.models import segmental_bridge

FRICTION, CONTACT = 0.6, 0.3


class Bridge(NamedTuple):
    """A segmental ring [m] of voussoirs [kg/m3] below fill [N/m3]."""

    span: float = 6.0
    rise: float = 1.5
    ring: float = 0.45
    count: int = 30
    density: float = 2200.0
    soil: float = 20e3
    cover: float = 0.3


BRIDGE = Bridge()


def own_limit(place: float, k: float = 0.0, passive: float = 0.0, bridge: Bridge = BRIDGE) -> float:
    """The largest axle [kN] on a segmental ring with fill, or point load without, by statics.

    Per joint a compression at the intrados and one at the extrados, and a shear of at most friction
    times their sum; three equations per voussoir. The axle spreads by 1/2 to each side, down to the
    extrados below it.
    """
    span, rise, ring, count, density, soil, cover = bridge
    radius = (0.25 * span**2 + rise**2) / (2.0 * rise)
    low = rise - radius
    half = np.arcsin(0.5 * span / radius)
    angle = np.linspace(-half, half, count + 1)
    ray = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    centre = np.array([0.5 * span, low])
    inner, outer = centre + radius * ray, centre + (radius + ring) * ray
    along = np.stack([np.cos(angle), -np.sin(angle)], axis=1)  # normal of a joint, to the right
    road = float(outer[:, 1].max()) + cover
    at = int(np.clip(np.searchsorted(outer[:, 0], place) - 1, 0, count - 1))
    share = (place - outer[at, 0]) / (outer[at + 1, 0] - outer[at, 0])
    depth = road - (outer[at, 1] + share * (outer[at + 1, 1] - outer[at, 1]))
    wide = CONTACT + depth if soil else 1e-9
    balance, dead, live = np.zeros((3 * count, 3 * count + 3)), np.zeros(3 * count), []
    held = np.zeros((3 * count, count))
    for i in range(count):
        for joint, sign in ((i, 1.0), (i + 1, -1.0)):
            for column, (way, point) in enumerate(((along, inner), (along, outer), (ray, inner))):
                force, where = sign * way[joint], point[joint]
                turn = where[0] * force[1] - where[1] * force[0]
                balance[3 * i : 3 * i + 3, 3 * joint + column] = *force, turn
        (xa, za), (xb, zb) = outer[i], outer[i + 1]
        corner = np.array([inner[i], inner[i + 1], outer[i + 1], outer[i]])
        x, z = corner.T
        cross = x * np.roll(z, -1) - np.roll(x, -1) * z
        area = 0.5 * cross.sum()
        middle = ((x + np.roll(x, -1)) * cross).sum() / (6.0 * area)
        ha, hb, length = road - za, road - zb, xb - xa
        fill = soil * length * np.array([ha, hb]) @ [0.5, 0.5]
        centroid = xa + length * (ha + 2.0 * hb) / (3.0 * (ha + hb))
        dead[3 * i + 1] = -abs(area) * density * 9.81 - fill
        dead[3 * i + 2] = -abs(area) * density * 9.81 * middle - fill * centroid
        step = (zb - za) / 2.0 * np.array([1.0, 4.0, 1.0]) / 3.0  # Simpson: exact for cubics
        level = np.array([za, 0.5 * (za + zb), zb])
        push = soil * (road - level) * step
        sideways = np.array([push.sum(), 0.0, -(level * push).sum()])
        dead[3 * i : 3 * i + 3] += k * sideways
        held[3 * i : 3 * i + 3, i] = (passive - k) * sideways if passive else 0.0
        left, right = max(xa, place - 0.5 * wide), min(xb, place + 0.5 * wide)
        force = max(right - left, 0.0) / wide * 1e3
        live += [0.0, -force, -force * 0.5 * (left + right)]
    joints = count + 1
    friction = np.zeros((2 * joints, 3 * joints))
    for j in range(joints):
        friction[2 * j, 3 * j : 3 * j + 3] = -FRICTION, -FRICTION, 1.0
        friction[2 * j + 1, 3 * j : 3 * j + 3] = -FRICTION, -FRICTION, -1.0
    bounds = [(0, None), (0, None), (None, None)] * joints + [(0, 1)] * count + [(0, None)]
    matrix = np.column_stack([balance, held, live])
    limits = np.column_stack([friction, np.zeros((2 * joints, count + 1))])
    price = np.zeros(matrix.shape[1])
    price[-1] = -1.0
    found = linprog(price, limits, np.zeros(len(limits)), matrix, -dead, bounds)
    return float(found.x[-1])


def carried(bridge: Bridge, fill: Fill, steps: int) -> TrainEnvelope:
    """What drystone says of an axle of 1 kN on a metre of a bridge."""
    made = segmental_bridge(bridge.span, bridge.rise, bridge.ring, bridge.count)
    model = Model.of(made.with_density(bridge.density), friction=FRICTION)
    train, quick = Train.named("axle"), LimitOptions(equilibrium_only=True)
    return limit_train(model, train=train, fill=fill, steps=steps, options=quick)


@pytest.mark.parametrize("k", [0.0, 0.3, 1.5])
@pytest.mark.parametrize("passive", [0.0, 2.0])
def test_an_axle_is_carried_as_a_plane_program_says(k: float, passive: float) -> None:
    found = carried(BRIDGE, Fill(0.3, 20e3, k=k, passive=passive), steps=6)
    own = [own_limit(float(place), k, passive) for place in found.places[:3]]
    assert found.factors[:3] == pytest.approx(own, rel=1e-5)
    assert found.factors[::-1][:3] == pytest.approx(own, rel=1e-5)


@pytest.mark.parametrize(("cover", "passive", "share"), [(0.1, 0.0, 0.43), (0.25, 3.0, 1.04)])
def test_prestwood_is_told_from_two_fifths_of_its_test_to_all_of_it(
    cover: float, passive: float, share: float
) -> None:
    """228 kN at quarter span, by Page 1987; other figures from Simoncello and others 2020.

    The depth of the fill at the crown is not in what was read. A third of the vertical pressure is
    the active one of soil of 30 degrees, and three times that the whole passive one.
    """
    soil, width = 2040.0 * 9.81, 3.8
    bridge = Bridge(6.55, 1.428, 0.22, 30, 1800.0, soil, cover)
    found = carried(bridge, Fill(cover, soil, k=1.0 / 3.0, passive=passive), steps=2)
    at = int(np.argmin(np.abs(found.places - 0.25 * bridge.span)))
    own = own_limit(float(found.places[at]), 1.0 / 3.0, passive, bridge)
    assert found.factors[at] == pytest.approx(own, rel=1e-5)
    tested = width * own_limit(0.25 * bridge.span, 1.0 / 3.0, passive, bridge) / 228.0
    assert tested == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(
    ("ring", "width", "tested", "share"), [(0.06, 0.3, 0.39, 0.55), (0.12, 0.25, 2.08, 0.38)]
)
def test_bare_vaults_are_told_from_a_third_to_two_thirds_of_their_tests(
    ring: float, width: float, tested: float, share: float
) -> None:
    """Carozzi and others 2018, as transcribed: a jack 0.556 m from the left springing.

    The density is not in what was read; the load grows as it does: 11 % to each side from 1600 to
    2000 kg/m3. Of 59 voussoirs, a brick and its joint each, the jack is on that numbered 12.
    """
    bridge, quick = (
        Bridge(3.3, 0.83, ring, 59, 1800.0, soil=0.0),
        LimitOptions(equilibrium_only=True),
    )
    made = segmental_bridge(bridge.span, bridge.rise, ring, bridge.count)
    model = Model.of(made.with_density(bridge.density), friction=FRICTION)
    found = limit_load(model, "voussoir-12:0,0,-1kN@0.556,0.5,0.5", options=quick)
    own = own_limit(0.556, bridge=bridge)
    assert found.stands == pytest.approx(own, rel=2e-4)
    assert width * own / tested == pytest.approx(share, abs=0.01)


def test_backing_holds_the_haunches_of_a_bridge() -> None:
    """Solid masonry up to a level carries more of an axle the higher it is, and both ends alike."""
    least, quick = [], LimitOptions(equilibrium_only=True)
    for height in (0.0, 0.4, 0.8):
        made = segmental_bridge(6.0, 1.5, 0.45, 8, backing=height)
        if height:
            left, right = made.blocks[-2:]
            foot = float(made.blocks[0].bounds[1, 2])
            assert made.names[-2:] == ("backing-left", "backing-right")
            assert left.volume == pytest.approx(right.volume)
            assert left.bounds[:, 2] == pytest.approx([foot, foot + height])
        model = Model.of(made, friction=FRICTION)
        fill = Fill(0.3, 20e3)
        found = limit_train(model, fill=fill, steps=4, options=quick)
        assert found.factors == pytest.approx(found.factors[::-1], rel=1e-5)
        assert found.proven
        loaded = model.with_load(model.load + fill.on(made))
        assert check(loaded).stable
        least.append(found.factors.min())
    assert least[0] < 0.95 * least[1] < 0.9 * least[2]


@pytest.mark.parametrize(
    ("given", "told"),
    [({"backing": 3.0}, "below the crown"), ({"backing": 0.5, "spans": 2}, "give one span")],
)
def test_backing_that_cannot_be_is_told(given: dict[str, float], told: str) -> None:
    with pytest.raises(InputError, match=told):
        segmental_bridge(voussoirs=8, **given)  # type: ignore[arg-type]
