"""Paths do not depend on how the blocks are numbered."""

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drystone import Assembly, LoadCase, Model, settle
from drystone.base.arrays import Bools
from drystone.contacts import Contacts
from drystone.mechanics.bodies import BlockPositions, build_bodies, place_corners
from drystone.mechanics.corners import Carrier, as_turned, joint_ends, turned_joints
from drystone.models import arch, box, concave, tower, wedge
from drystone.settlement import (
    Outcome,
    Settlement,
    SettlementOptions,
    move_supports,
    push,
    reduce_friction,
)

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def in_order(assembly: Assembly, order: tuple[int, ...]) -> Assembly:
    """The same blocks with other numbers."""
    return Assembly(tuple(assembly.blocks[i] for i in order), assembly.fixed[list(order)])


def tilted(
    assembly: Assembly, axis: tuple[float, float, float], angle: float, options: SettlementOptions
) -> Settlement:
    load = LoadCase.tilt(assembly, axis, angle)
    return settle(Model.of(assembly, friction=0.84, load=load), options=options)


def with_other_normals(contacts: Contacts) -> Contacts:
    """The same interfaces, of b and a in place of a and b."""
    signs = np.array([-1.0, 1.0, -1.0])
    return replace(
        contacts,
        block_a=contacts.block_b,
        block_b=contacts.block_a,
        frame=contacts.frame * signs[:, None],
        point=contacts.point[_backwards(contacts)],
    )


def _backwards(contacts: Contacts) -> np.ndarray:
    """The corners of each interface the other way round."""
    start = contacts.start
    return np.concatenate(
        [np.arange(end - 1, first - 1, -1) for first, end in itertools.pairwise(start)]
    )


@cache
def wedge_in_order(carrier: Carrier, angle: float, order: tuple[int, ...]) -> Settlement:
    options = SettlementOptions(carrier=carrier, fall=0.02)
    return tilted(in_order(wedge("c", longer=0.2), order), X, angle, options)


@pytest.mark.parametrize("carrier", list(Carrier))
@pytest.mark.parametrize("order", [(0, 2, 1), (2, 1, 0), (1, 2, 0)], ids=str)
def test_a_wedge_close_to_its_limit_goes_one_way(carrier: Carrier, order: tuple[int, ...]) -> None:
    # of the six orders two rested at 44.2 and four fell; within 0.05 degrees rounding still decides
    for angle, outcome in ((44.1, Outcome.RESTS), (44.2, Outcome.FALLS)):
        first = wedge_in_order(carrier, angle, (0, 1, 2))
        other = wedge_in_order(carrier, angle, order)
        assert first.outcome is other.outcome is outcome
        assert other.travel == pytest.approx(first.travel, rel=1e-6)


@pytest.mark.parametrize("carrier", list(Carrier))
def test_a_concave_joint_has_the_same_forces_in_every_order(carrier: Carrier) -> None:
    options = SettlementOptions(carrier=carrier)
    plain = concave("short")
    order = tuple(range(len(plain)))[::-1]
    first = tilted(plain, Y, 30.0, options)
    other = tilted(in_order(plain, order), Y, 30.0, options)
    assert first.outcome is other.outcome is Outcome.RESTS
    assert other.travel == pytest.approx(first.travel, rel=1e-6)
    moved = other.path.displacement[list(np.argsort(order))]
    np.testing.assert_allclose(moved, first.path.displacement, atol=1e-6 * first.travel)
    # what every block carries in all, as a vector
    for i in range(len(plain)):
        np.testing.assert_allclose(
            _on_block(other, order.index(i)), _on_block(first, i), atol=1e-6 * plain.mass.max()
        )


def _on_block(settled: Settlement, block: int) -> np.ndarray:
    """(3,) [N] sum of the corner forces on a block, in the axes of the model."""
    path = settled.path
    contacts = path.model.contacts
    world = np.einsum("ki,kij->kj", path.force, path.axes)
    on_b = (contacts.block_b == block)[contacts.interface]
    on_a = (contacts.block_a == block)[contacts.interface]
    total: np.ndarray = world[on_b].sum(axis=0) - world[on_a].sum(axis=0)
    return total


def test_many_blocks_go_the_same_way_in_every_order() -> None:
    plain = arch(0.15, 29)
    options = SettlementOptions(carrier=Carrier.MOVING, fall=0.02)
    first = tilted(plain, Y, 5.0, options)
    order = tuple(int(i) for i in np.random.default_rng(4).permutation(len(plain)))
    other = tilted(in_order(plain, order), Y, 5.0, options)
    assert first.outcome is other.outcome is Outcome.RESTS
    # increments of many blocks leave a tenth of what the drag carries to the next one
    assert other.travel == pytest.approx(first.travel, rel=1e-3)


def test_large_displacements_have_the_same_curve_in_every_order() -> None:
    blocks = (
        box((3.0, 3.0, 1.0), (-1.0, -1.0, -1.0), "base"),
        box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), "lower"),
        box((1.0, 1.0, 2.0), (0.0, 0.0, 1.0), "upper"),
    )
    plain = Assembly(blocks).with_fixed(["base"])
    turn = {"base": (0.0, 0.0, 0.0, 0.0, 0.2, 0.0)}
    for work, order in (
        (lambda one: push(one, friction=0.7, to=0.2), (2, 1, 0)),
        (lambda one: move_supports(one, turn, friction=0.7), (1, 2, 0)),
        (
            lambda one: reduce_friction(
                Model.of(one, friction=0.7, load=LoadCase.tilt(one, (0.0, 1.0, 0.0), 5.0))
            ),
            (0, 2, 1),
        ),
    ):
        first, second = work(plain), work(in_order(plain, order))
        assert first.end is second.end
        assert second.load.max() == pytest.approx(first.load.max(), rel=1e-6, abs=1e-3)
        np.testing.assert_allclose(
            second.states[-1].displacement, first.states[-1].displacement, rtol=1e-4
        )
        pressing = second.states[-1].force[:, 0]
        assert pressing.sum() == pytest.approx(first.states[-1].force[:, 0].sum(), rel=1e-5)


@pytest.mark.parametrize("carrier", list(Carrier))
@pytest.mark.parametrize(
    "assembly", [wedge("a"), wedge("c", longer=0.2), concave("long"), arch(0.2, 5)]
)
def test_ends_with_other_roles_are_those_of_the_interface_the_other_way_round(
    assembly: Assembly, carrier: Carrier
) -> None:
    contacts = Model.of(assembly, friction=0.6).contacts
    other = with_other_normals(contacts)
    nothing = np.zeros((contacts.corner_count, 2))
    every: Bools = np.ones(contacts.corner_count, dtype=bool)
    found = as_turned(joint_ends(assembly, contacts, carrier, nothing), every)
    wanted = joint_ends(assembly, other, carrier, nothing)
    back = _backwards(contacts)
    for name in ("outward", "share", "tangent", "sense", "reach"):
        np.testing.assert_allclose(
            getattr(found, name)[back], getattr(wanted, name), atol=1e-12, err_msg=name
        )
    edge = [one.place[one.after] - one.place for one in (found, wanted)]
    np.testing.assert_allclose(edge[0][back], edge[1], atol=1e-12)


def test_corners_slide_over_the_block_that_is_nearer_to_a_support() -> None:
    plain = tower(3)
    for order in itertools.permutations(range(3)):
        model = Model.of(in_order(plain, order), friction=0.6)
        contacts = model.contacts
        under = np.where(turned_joints(model), contacts.block_b, contacts.block_a)
        over = np.where(turned_joints(model), contacts.block_a, contacts.block_b)
        height = model.assembly.centroid[:, 2]
        assert (height[under] < height[over]).all()


def test_gaps_and_points_do_not_depend_on_the_order() -> None:
    plain = wedge("b")
    found = []
    for order in ((0, 1, 2), (2, 1, 0)):
        model = Model.of(in_order(plain, order), friction=0.6)
        part = model.with_contacts(model.contacts.select(model.active))
        bodies = build_bodies(part, Carrier.MOVING, overlap=1e-6, tangential=0.2)
        start = BlockPositions(bodies.centroid, np.tile(np.eye(3), (3, 1, 1)))
        pose = start.moved(bodies.free, np.array([[0.01, -0.02, 0.005, 0.02, 0.01, -0.03]]))
        placed = place_corners(bodies, pose)
        rows = np.concatenate([placed.point, placed.gap[:, None], placed.axes[:, 0]], axis=1)
        found.append(rows[np.lexsort(np.round(placed.point, 6).T)])
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)
