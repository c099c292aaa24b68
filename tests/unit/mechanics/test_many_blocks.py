"""What is done differently for many blocks gives the same as for few."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drystone import LoadCase, Model, settle
from drystone.base.settings import Clock
from drystone.mechanics.bodies import BlockPositions, Bodies, build_bodies, place_corners
from drystone.mechanics.corners import Carrier
from drystone.mechanics.law import respond
from drystone.mechanics.maps import FullMaps, SparseMaps
from drystone.mechanics.meeting import faces_apart
from drystone.models import arch
from drystone.settlement import Outcome, SettlementOptions, SettlementPath
from drystone.settlement.path import FollowedCase, path_of


def moved_arch() -> tuple[Bodies, FullMaps, SparseMaps]:
    """An arch whose blocks have moved, with both kinds of maps."""
    model = Model.of(arch(0.2, 9), friction=0.6)
    followed = model.with_contacts(model.contacts.select(model.active))
    bodies = build_bodies(followed, Carrier.MOVING, overlap=1e-6, tangential=0.2)
    rng = np.random.default_rng(3)
    start = BlockPositions(bodies.centroid, np.tile(np.eye(3), (len(bodies.centroid), 1, 1)))
    pose = start.moved(bodies.free, 1e-2 * rng.normal(size=(len(bodies.free), 6)))
    a, b = bodies.slot[bodies.block_a], bodies.slot[bodies.block_b]
    few = FullMaps(a, b, len(bodies.free))
    many = SparseMaps(a, b, bodies.radius[bodies.free], bodies.centroid[bodies.free])
    for one in (few, many):
        put(bodies, one, pose)
    return bodies, few, many


def put(bodies: Bodies, maps: FullMaps | SparseMaps, pose: BlockPositions) -> None:
    """Renew maps for positions of the blocks."""
    placed = place_corners(bodies, pose)
    arms = (
        (placed.point - pose.place[block]) / bodies.radius[block, None]
        for block in (bodies.block_a, bodies.block_b)
    )
    maps.at(placed.axes, *arms)


def test_the_maps_of_many_blocks_are_those_of_few() -> None:
    bodies, dense, many = moved_arch()
    rng = np.random.default_rng(5)
    motion = rng.normal(size=(len(bodies.free), 6))
    force = rng.normal(size=(len(bodies.block_a), 3))
    np.testing.assert_allclose(many.moved(motion), dense.moved(motion), atol=1e-12)
    np.testing.assert_allclose(many.wrench(force), dense.wrench(force), atol=1e-12)
    pressed = respond(bodies.springs, -1e-6 * rng.random(len(force)), force[:, 1:])
    weight = np.full((len(bodies.free), 6), 1e3)
    tangent = pressed.tangent
    np.testing.assert_allclose(
        many.factorise(tangent, weight)(motion),
        dense.factorise(tangent, weight)(motion),
        rtol=1e-8,
        atol=1e-12,
    )


def test_joints_that_have_not_changed_keep_their_stiffness() -> None:
    """Few tangents change, then none, then all blocks move: the solution is that of new maps."""
    bodies, dense, many = moved_arch()
    rng = np.random.default_rng(7)
    wrench = rng.normal(size=(len(bodies.free), 6))
    weight = np.full((len(bodies.free), 6), 1e3)
    tangent = np.tile(np.diag([3e6, 1e6, 1e6]), (len(bodies.block_a), 1, 1))
    few = tangent.copy()
    few[4:7] *= rng.random((3, 1, 1))
    start = BlockPositions(bodies.centroid, np.tile(np.eye(3), (len(bodies.centroid), 1, 1)))
    for asked in (tangent, few, few, tangent):
        np.testing.assert_allclose(
            many.factorise(asked, weight)(wrench), dense.factorise(asked, weight)(wrench), rtol=1e-9
        )
    for one in (dense, many):
        put(bodies, one, start)
    np.testing.assert_allclose(
        many.factorise(tangent, weight)(wrench), dense.factorise(tangent, weight)(wrench), rtol=1e-9
    )


def test_the_other_carrier_is_followed_from_where_many_blocks_rest() -> None:
    assembly = arch(0.15, 37)
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 8.0)
    model = Model.of(assembly, friction=0.8, load=load)
    apart, chosen = faces_apart(model, 0.3), SettlementOptions()
    clock = Clock(float("inf"), None)
    case = FollowedCase(model, apart, chosen, clock)
    first, _ = path_of(case, Carrier.MOVING, True)
    whole, _ = path_of(case, Carrier.RESTING, False)
    near, _ = path_of(case, Carrier.RESTING, False, other=first)
    assert near.outcome is whole.outcome is Outcome.RESTS
    assert near.residuals is not None
    assert near.residuals.largest < 1e-8
    np.testing.assert_allclose(near.positions[1], first.positions[-1], atol=1e-12)
    assert not near.positions[0].any()
    assert near.steps < whole.steps / 2
    assert near.travel.max() == pytest.approx(whole.travel.max(), rel=0.02)


def test_both_carriers_of_many_blocks_are_followed_on_springs_of_one_stiffness(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where springs are too soft for the second one only, the first one is followed again."""
    assembly = arch(0.15, 37)
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 8.0)
    model = Model.of(assembly, friction=0.8, load=load)
    asked: list[tuple[Carrier, float | None]] = []

    def told(
        case: FollowedCase, carrier: Carrier, first: bool, *, overlap: float | None, **how: Any
    ) -> tuple[SettlementPath, bool]:
        asked.append((carrier, overlap))
        stiff = 1e-8 if carrier is Carrier.RESTING else overlap
        path, _last = path_of(case, carrier, first, overlap=stiff, **how)
        if len(asked) == 1:
            path = replace(path, outcome=Outcome.FALLS)
        return path, False

    monkeypatch.setattr("drystone.settlement.settling.path_of", told)
    found = settle(model)
    assert asked == [(Carrier.MOVING, None), (Carrier.RESTING, None), (Carrier.MOVING, 1e-8)]
    assert found.outcome is Outcome.RESTS
    assert [path.overlap for path in found.paths] == [1e-8, 1e-8]


def test_blocks_that_springs_move_far_are_followed_on_stiffer_ones() -> None:
    """The answer is that of the stiffer springs; where blocks hardly move, nothing is repeated."""
    ring = arch(0.3, 30)
    tilted = Model.of(ring, friction=0.84, load=LoadCase.tilt(ring, (0.0, 1.0, 0.0), 15.0))

    def followed(overlap: float) -> SettlementPath:
        options = SettlementOptions(carrier="moving", overlap=overlap)  # type: ignore[arg-type]
        return settle(tilted, options=options).path

    soft, stiff = followed(1e-4), followed(1e-5)
    assert soft.overlap == pytest.approx(1e-5)
    assert stiff.overlap == pytest.approx(1e-5)
    assert 0.003 < stiff.travel.max() < 0.005
    assert soft.travel == pytest.approx(stiff.travel, rel=1e-9, abs=1e-12)
