"""Passive pressure of fill as rods that yield: the law of ties, against closed forms and rows.

What fill resists on a block beyond its pressure at rest is a force between zero and
``(passive - k) sigma_v A`` against the motion into the fill. That is a rod from the block to a
support, along this force and at its place, which yields at its size.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import drystone
from drystone import Assembly, Contacts, JointCapacity, Model
from drystone.contacts import joined_contacts
from drystone.geometry.frames import frames_from_normals
from drystone.io.opening import as_model
from drystone.limits import LimitOptions, limit_train
from drystone.loads import Fill, LoadCase, Train
from drystone.loads.fill import Tops
from drystone.models import box, segmental_bridge
from drystone.models.simple import prism
from drystone.settlement import Outcome, push

FILL = Fill(cover=0.5, weight=20e3, k=0.3, passive=3.0)
POINT = 0.01
"""Size of the corners of a rod by that of its plate."""


def with_rods(model: Model, fill: Fill) -> Model:
    """The model with a rod on each free block that fill resists, to the nearest support."""
    assembly = model.assembly
    wrench = Tops.of(assembly, fill).pressed(0.0, fill.passive - fill.k)
    fixed = np.flatnonzero(assembly.fixed)
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    for block in np.flatnonzero(~assembly.fixed & wrench[:, :3].any(axis=1)).tolist():
        force, moment = wrench[block, :3], wrench[block, 3:]
        size = float(np.linalg.norm(force))
        assert abs(moment @ force) < 1e-9 * size**2  # one force, without a torque along it
        point = assembly.centroid[block] + np.cross(force, moment) / size**2
        away = np.linalg.norm(assembly.centroid[fixed] - point, axis=1)
        frame = frames_from_normals((force / size)[None])
        half = 0.05 * float(assembly.size[block])
        rod = Contacts(
            fixed[[away.argmin()]],
            np.array([block]),
            frame,
            np.array([4.0 * half**2]),
            np.zeros(1),
            point + POINT * half * corners @ frame[0, 1:],
            np.zeros(4, dtype=np.intp),
        )
        strength = JointCapacity.of(rod, compression=size / POINT**2)
        rod = rod.with_capacity(strength)
        model = model.with_contacts(joined_contacts(model.contacts, rod))
    return model


def against_fill() -> Model:
    """A block of 1 m height with a slope of 45 degrees, below fill, on ground without friction.

    A lid keeps the fill from its upright back.
    """
    block = prism([(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (0.0, 1.0)], (0.0, 1.0), "block")
    base = box((6.0, 3.0, 0.5), (-2.0, -1.0, -0.5), "base")
    lid = box((2.0, 3.0, 0.1), (-2.0, -1.0, 1.0), "lid")
    blocks = Assembly((base, block, lid), [True, False, True])
    model = Model.of(blocks, friction=0.0)
    return with_rods(model.with_load(model.load + FILL.on(blocks)), FILL)


def pushed(model: Model, force: float) -> LoadCase:
    """A force on the block, into the fill."""
    wrench = np.zeros((len(model), 6))
    wrench[1, 0] = force
    return LoadCase(wrench, "pushed")


MEAN = 20e3 * (0.5 + 0.5)
"""Vertical pressure [Pa] at half the height; on 1 m2 of the vertical."""


@pytest.mark.parametrize(("share", "stands"), [(0.99, True), (1.01, False)])
def test_a_block_stands_against_fill_up_to_its_passive_pressure(share: float, stands: bool) -> None:
    model = against_fill()
    model = model.with_load(model.load + pushed(model, share * 3.0 * MEAN))
    found = drystone.check(model)
    assert (found.stable, found.falls) == (stands, not stands)
    outcome = drystone.settle(model).outcome
    assert outcome is (Outcome.RESTS if stands else Outcome.FALLS)


def test_a_block_that_leaves_fill_is_followed_by_its_pressure_at_rest_only() -> None:
    model = against_fill()
    for share, outcome in ((1.01, Outcome.RESTS), (0.99, Outcome.FALLS)):
        load = model.load + pushed(model, share * 0.3 * MEAN)
        assert drystone.settle(model.with_load(load)).outcome is outcome


def test_a_push_into_fill_ends_at_its_passive_pressure() -> None:
    model = against_fill()
    model = model.with_load(model.load + pushed(model, 0.3 * MEAN))
    found = push(model, pushed(model, MEAN), to=0.1)
    assert found.peak == pytest.approx(3.0 - 0.3, rel=1e-4)
    assert found.load[-1] == pytest.approx(found.peak, rel=1e-4)


@pytest.mark.parametrize("passive", [1.0, 3.0])
def test_a_train_is_carried_as_with_rows_of_a_program(passive: float) -> None:
    bridge = Model.of(segmental_bridge(6.0, 1.5, 0.45), friction=0.6)
    fill = replace(FILL, passive=passive)
    quick = LimitOptions(equilibrium_only=True)
    rows = limit_train(bridge, fill=fill, steps=3, options=quick)
    rods = limit_train(
        with_rods(bridge, fill), fill=replace(fill, passive=0.0), steps=3, options=quick
    )
    assert rods.proven
    assert rods.factors == pytest.approx(rows.factors, rel=1e-6)


def test_the_tie_fill_is_these_rods() -> None:
    """On both sides of what rows of a program say for an axle at 1.32 m."""
    bridge = segmental_bridge(6.0, 1.5, 0.45)
    at = np.array([1.32])
    live = LoadCase(Train.named("axle").on(Tops.of(bridge, FILL), at)[0], "axle")
    given = "fill:cover=0.5m,weight=20kN/m3,k=0.3,passive=3"
    bare = as_model(bridge, load=given)
    model = as_model(bridge, load=given, tie="fill")
    rows = limit_train(bare, steps=2, options=LimitOptions(equilibrium_only=True))
    limit = float(rows.factors[np.abs(rows.places - at).argmin()])
    below, above = (0.97 * limit) * live, (1.01 * limit) * live
    assert drystone.check(bare.with_load(bare.load + below)).falls
    found = drystone.check(model.with_load(model.load + below))
    assert found.stable
    assert found.message == "stands, also within the strength of its ties"
    last = drystone.check(model.with_load(model.load + (0.9999 * limit) * live))
    assert last.message == "stands; ties yield"
    assert drystone.check(model.with_load(model.load + above)).falls
    (ties,) = [one for one in found.tables() if one.title == "ties"]
    own = with_rods(Model.of(bridge), FILL).contacts
    assert ties["strength"] == pytest.approx(own.tie_strength[own.ties])
    assert ties["strength_use"].max() <= 1.0 + 1e-6
    shown = found.contacts
    assert shown.centroid[shown.ties] == pytest.approx(own.centroid[own.ties])
    assert shown.frame[shown.ties, 0] == pytest.approx(own.frame[own.ties, 0])


def test_fill_that_acts_as_ties_is_not_counted_twice_and_gets_a_verdict() -> None:
    bridge = segmental_bridge(6.0, 1.5, 0.45)
    rows = limit_train(bridge, fill=FILL, steps=2)
    given = "fill:cover=0.5m,weight=20kN/m3,k=0.3,passive=3"
    ties = limit_train(bridge, load=given, tie="fill", steps=2)
    assert ties.factors == pytest.approx(rows.factors, rel=1e-6)
    assert rows.limit is None
    assert ties.limit is not None
    assert ties.limit.falls == pytest.approx(ties.factors[ties.worst], rel=0.01)


def test_an_axle_is_pushed_down_up_to_the_factor_of_the_program() -> None:
    """The haunches move into the fill, and the axle grows to what rows of a program say."""
    bridge = Model.of(segmental_bridge(6.0, 1.5, 0.45), friction=0.9)
    axle = Train.named("axle")
    rows = limit_train(
        bridge, train=axle, fill=FILL, steps=3, options=LimitOptions(equilibrium_only=True)
    )
    live = LoadCase(axle.on(Tops.of(bridge.assembly, FILL), rows.places)[rows.worst], "axle")
    alone = bridge.with_load(bridge.load + FILL.on(bridge.assembly))
    assert push(alone, live, to=0.02).peak < 0.7 * float(rows.factors[rows.worst])
    found = push(with_rods(alone, FILL), live, to=0.02)
    assert found.peak == pytest.approx(float(rows.factors[rows.worst]), rel=0.01)
