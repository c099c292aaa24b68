"""Trains over bridges: the envelope, what fill resists, workers, files, and what is refused."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

from drystone import (
    Assembly,
    Block,
    InputError,
    JointCapacity,
    LoadCase,
    Model,
    Result,
    Verdict,
    check,
    read,
)
from drystone.answer import Role
from drystone.cli import main
from drystone.formulations.equilibrium import LoadFactors
from drystone.geometry.frames import rotations
from drystone.limits import LimitOptions, limit_load, limit_train
from drystone.limits.limit_types import verdict
from drystone.loads import Fill, Train
from drystone.loads.fill import Tops
from drystone.models import box, segmental_bridge, tower
from drystone.solvers.program import ConicProgram, ProgramBuilder

FILL = Fill(cover=0.3, weight=2e4)
AXLE = Train("axle", (0.0,), (1e5,), contact=0.4)


@pytest.fixture(scope="module")
def bridge() -> Model:
    return Model.of(segmental_bridge(voussoirs=10), friction=0.6)


def test_every_place_has_the_factor_of_its_own_limit_of_load(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, fill=FILL, steps=4, options=quick)
    loaded = bridge.with_load(bridge.load + FILL.on(bridge.assembly))
    place, factor = float(found.places[1]), found.factors[1]
    alone = limit_load(loaded, found.live(place), options=quick)
    assert alone.equilibrium.stands < factor < alone.equilibrium.falls  # type: ignore[operator]
    assert found.factors == pytest.approx(found.factors[::-1], rel=1e-6)
    assert found.proven


def test_the_worst_place_stands_just_below_its_limit_and_falls_just_above(bridge: Model) -> None:
    found = limit_train(bridge, fill=FILL, steps=5)
    assert found.limit is not None
    count = len(found.places)
    words = f"the verdict is least at x = 1.27 m of {count} places: at the others it stands under"
    assert f"{words} that" in [one.text for one in found.sentences()]
    unsure = replace(found, _undecided=(0, 3))
    assert unsure.title == "Forces balance 'axle' up to load factor 209.5, least at x = 1.27 m"
    late = replace(found, stopped="the time was up", asked_for=10)
    assert late.title.endswith(f"factor 209.5, least of {count} of 10 places at x = 1.27 m")
    assert late.sentences()[0].role is Role.UNSURE
    told = f"at 2 of {count} places it is undecided under that factor"
    assert told in "; ".join(one.text for one in unsure.sentences())
    assert found.limit.rest is not None
    rest = replace(found.limit.rest, stands=1.44189)
    near = replace(found, limit=replace(found.limit, rest=rest))
    assert "up to load factor 1.441, least" in near.title
    least = replace(found, factors=np.full(len(found.places), 1.44189))
    assert {row[1] for row in least.table().cells()[1]} == {"1.441"}
    assert near.code == 0
    rest = replace(rest, stands=0.93318)
    under = replace(near, limit=replace(found.limit, rest=rest))
    assert under.title.startswith("Does not carry 'axle', only 0.9331 of it, least at x")
    assert under.code == 1
    assert "drystone mend with this --train" in under.sentences()[-1].text
    told = "1.441 by equilibrium, 0.9331 by the verdict"
    assert told in replace(under, factors=least.factors).figure().caption
    first, beyond = under.layers().stages[:2]
    assert first.headline == under.title
    assert first.role is Role.BAD
    assert beyond.headline.startswith(f"{under.title}; falls at ")
    drawn = replace(least, factors=0.7 * least.factors).figure().marks
    assert [one.y.tolist() for one in drawn if one.label == "the train: 1"] == [[1.0, 1.0]]
    live = found.live(float(found.places[found.worst]))
    for factor, stands in ((found.limit.stands, True), (found.limit.falls, False)):
        assert factor is not None
        assert check(found.model.with_load(found.model.load + factor * live)).stable is stands


def test_fill_of_the_load_is_that_of_the_train(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    loaded = bridge.with_load(bridge.load + 1.0 * FILL.on(bridge.assembly))
    found = limit_train(loaded, steps=2, options=quick)
    assert found.fill == FILL
    added = limit_train(bridge, fill=FILL, steps=2, options=quick)
    assert found.factors == pytest.approx(added.factors)
    double = limit_train(bridge.with_load(2.0 * FILL.on(bridge.assembly)), steps=2, options=quick)
    assert double.fill == replace(FILL, weight=2.0 * FILL.weight)
    with pytest.raises(InputError, match="negative"):
        limit_train(bridge.with_load(bridge.load + -1.0 * FILL.on(bridge.assembly)))


def test_what_fill_resists_helps_and_is_bounded(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    factors = []
    for passive in (0.0, 0.5, 2.0, 15.0):
        fill = replace(FILL, k=0.2, passive=passive)
        found = limit_train(bridge, fill=fill, steps=3, options=quick)
        assert found.proven
        factors.append(found.factors[0])
    assert factors[0] < factors[1] < factors[2] < factors[3]


def test_no_verdict_counts_what_fill_resists(bridge: Model) -> None:
    fill = Fill(cover=0.3, weight=2e4, k=0.2, passive=3.0)
    found = limit_train(bridge, fill=fill, steps=2)
    assert found.limit is None
    assert found.title.startswith("Forces balance")
    plain = replace(fill, passive=0.0).on(bridge.assembly)
    assert fill.on(bridge.assembly).wrench == pytest.approx(plain.wrench)
    assert "limit train" in fill.on(bridge.assembly).notes[0]


def test_the_worst_place_is_that_of_the_verdict_not_of_ductile_joints(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of two planks that tip by hand the glued one falls first: its glue breaks.

    Were the verdict undecided at the first place under any factor, it would be told.
    """
    two = Assembly(
        (
            *(box((2.0, 1.0, 1.0), (x, 0.0, -1.0), name) for x, name in ((-1.0, "a"), (3.2, "b"))),
            *(box((4.0, 1.0, 0.1), (x, 0.0, 0.0), name) for x, name in ((-2.0, "c"), (2.2, "d"))),
        ),
        [True, True, False, False],
    ).with_density([2400.0, 2400.0, 2400.0, 960.0])
    model = Model.of(two, friction=0.6)
    glued = model.with_capacity(JointCapacity.of_stress(model.contacts, tension=[0.0, 4e3]))
    axle = Train("axle", (0.0,), (1e3,), contact=0.1)
    found = limit_train(glued, train=axle, steps=4)
    weight = 9.81 * 960.0 * 0.4
    assert found.limit is not None
    assert found.limit.stands == pytest.approx(weight / 950.0, rel=1e-3)
    assert found.factors.min() > 2.0 * found.limit.stands
    assert found.places[found.worst] == pytest.approx(2.25, abs=1e-3)
    said = [one.text for one in found.sentences()]
    assert found.sentences()[0].role is Role.GOOD
    assert "ductile" not in found.title
    assert any("between them it may be less" in one for one in said)
    rest = found.title.split("load factor ")[1].split(",")[0]
    least = f"with ductile joints by equilibrium; {rest} or more by the verdict"
    others = [one for i, one in enumerate(found.carries) if i != found.worst]
    assert all(one.endswith(least) for one in others)

    def unsure(model: Model, **how: Any) -> Result:
        at_first = "axle at x = -0." in model.load.name
        result = verdict(model, **how)
        return replace(result, verdict=Verdict.UNDECIDED) if at_first else result

    monkeypatch.setattr("drystone.limits.train_limit.verdict", unsure)
    open_ = limit_train(glued, train=axle, steps=4)
    assert open_.sentences()[0].role is Role.UNSURE
    assert open_.title.startswith("Forces balance 'axle' up to load factor")


def test_a_train_with_a_heavy_end_is_moved_both_ways(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    cart = Train("cart", (0.0, 2.0), (1e3, 5e3))
    assert cart.turned.loads == (5e3, 1e3)
    found = limit_train(bridge, train=cart, fill=FILL, steps=4, options=quick)
    other = limit_train(bridge, train=cart.turned, fill=FILL, steps=4, options=quick)
    assert found.factors == pytest.approx(other.factors)
    assert found.factors == pytest.approx(found.factors[::-1], rel=1e-6)
    for one in (found, other):
        way = "as given" if tuple(one.axles()["load"]) == one.train.loads else "turned round"
        told = " ".join(sentence.text for sentence in one.sentences())
        assert f"of both ways the train is worst {way}" in told


def test_strong_stone_carries_what_stone_that_never_crushes_does(bridge: Model) -> None:
    """Programs in units of strengths failed: at half of the places, so that one way was lost."""
    quick = LimitOptions(equilibrium_only=True)
    cart = Train("cart", (0.0, 1.1, 3.0), (6e4, 9e4, 4.5e4), contact=0.3)
    hard = bridge.with_capacity(JointCapacity.of_stress(bridge.contacts, compression=1e9))
    found = limit_train(hard, train=cart, fill=FILL, steps=2, options=quick)
    other = limit_train(bridge, train=cart, fill=FILL, steps=2, options=quick)
    assert found.factors[[0, -1]] == pytest.approx(other.factors[[0, -1]], rel=3e-3)
    lost = replace(found, factors=np.append(np.nan, found.factors[1:]))
    told = [one.text for one in lost.sentences() if one.role is Role.BAD]
    assert f"not found at x = {found.places[0]:.3g} m, where it may be less" in "; ".join(told)


PLANK = Assembly(
    (
        box((2.0, 1.0, 1.0), (-1.0, 0.0, -1.0), "rest"),
        box((4.0, 1.0, 0.1), (-2.0, 0.0, 0.0), "plank"),
    ),
    [True, False],
)


@pytest.mark.parametrize(
    ("clear", "arm"),
    [(None, 0.5), (0.25, 0.25 * (0.125 + 0.875)), (0.5, 0.0)],
)
def test_a_line_load_tips_a_plank_from_beyond_its_rest(clear: float | None, arm: float) -> None:
    """W b/2 = factor (P e + q a2/2): where it lies on the rest it would hold, and is left out."""
    train = Train("cart", (0.0,), (500.0,), line=1000.0, clear=clear)
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(Model.of(PLANK, friction=0.6), train=train, steps=4, options=quick)
    weight = float(PLANK.mass[1]) * 9.81
    at = int(np.argmin(np.abs(found.places - 1.5)))
    assert found.places[at] == pytest.approx(1.5)
    labels = [one.label for one in found.layers().stages[at].layers if one.group == "axles"]
    assert len(labels) == len(set(labels))  # each stretch of the line load is in one row
    assert found.factors[at] == pytest.approx(weight / (500.0 * 0.5 + 1000.0 * arm), rel=1e-6)
    middle = int(np.argmin(np.abs(found.places - 0.5)))
    if clear is None:
        assert found.factors[middle] == pytest.approx(weight / (1000.0 - 500.0) / 0.5, rel=1e-6)
        assert found.line[0] == pytest.approx([1.0, 2.0]) or found.line[0] == pytest.approx(
            [-2, -1]
        )


def test_no_stretch_of_the_line_load_is_worse_than_the_one_found(bridge: Model) -> None:
    train = Train("line", (0.0,), (1e4,), line=3e4)
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, train=train, fill=FILL, steps=1, options=quick)
    place = float(found.places[0])
    tops = Tops.of(bridge.assembly, FILL)
    loaded = bridge.with_load(bridge.load + FILL.on(bridge.assembly))
    axle = train.on(tops, found.places)[0]
    ends, pieces = train.pieces(tops, place)
    assert pieces.sum(axis=(0, 1))[2] == pytest.approx(-3e4 * np.diff(tops.road.ends)[0], rel=3e-2)
    for first in range(0, len(ends), 8):
        for last in range(first + 8, len(ends) + 1, 8):
            some = LoadCase(axle + pieces[first:last].sum(axis=0))
            other = limit_load(loaded, some, options=quick).equilibrium
            assert found.factors[0] <= (other.falls or np.inf)


def test_a_line_load_is_found_on_one_of_two_spans_on_a_free_pier() -> None:
    """Of all stretches an own plane program has 0.97223 and 1.12828; 1.0392 and 1.2162 were said.

    On fill without weight, which no surface load is drawn of.
    """
    made = segmental_bridge(spans=2, height=4.0, voussoirs=4, pier=1.0, courses=2)
    train = Train("line", (0.0,), (1e4,), contact=0.4, line=3e4)
    fill, quick = Fill(0.0, 0.0, spread=0.0), LimitOptions(equilibrium_only=True)
    model = Model.of(made, friction=0.6)
    found = limit_train(model, train=train, fill=fill, steps=1, options=quick)
    known = dict(zip(found.places.round(3).tolist(), found.factors.tolist(), strict=True))
    assert (known[2.967], known[6.5]) == pytest.approx((0.97223, 1.12828), rel=1e-4)
    assert found.worst == list(known).index(2.967)


def test_the_programs_of_one_place_are_one_program(
    bridge: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    built, build = [], ProgramBuilder.build

    def counted(program: ProgramBuilder) -> ConicProgram:
        built.append(program)
        return build(program)

    monkeypatch.setattr(ProgramBuilder, "build", counted)
    train = Train("line", (0.0,), (1e4,), line=3e4)
    fill = replace(FILL, k=0.2, passive=1.0)
    found = limit_train(bridge, train=train, fill=fill, steps=1)
    assert len(found.line)
    assert len(built) == len(found.places)


@pytest.mark.parametrize("steps", [3, 7, 21])
def test_the_worst_place_is_found_between_those_asked_for(steps: int) -> None:
    """W a = factor P (e - c / 2) of a beam that tips by an axle at its end, e beyond its rest."""
    rests = [box((0.5, 1.0, 1.0), (x, 0.0, -1.0), f"rest {x}") for x in (-2.5, 1.0)]
    beam = Assembly((*rests, box((6.0, 1.0, 0.3), (-3.0, 0.0, 0.0), "beam")), [True, True, False])
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(Model.of(beam, friction=0.6), steps=steps, options=quick)
    tips = float(beam.mass[2]) * 9.81 * 1.5 / (1e3 * (1.5 - 0.15))
    assert found.factors[found.worst] == pytest.approx(tips, rel=1e-3)
    assert found.places[found.worst] == pytest.approx(2.85, abs=2e-3)
    more = len(found.places) - steps
    assert more <= 4
    told = f"{len(found.places)} places ({more} of them where mechanisms of others end it sooner)"
    assert any(told in one.text for one in found.sentences())


def test_the_train_is_summed_by_hand(bridge: Model) -> None:
    """Each load times the part that a strip of 1 m bears, and all of an axle on its whole width."""
    quick = LimitOptions(equilibrium_only=True)
    train = Train("line", (0.0,), (1e4,), contact=0.4, line=3e4, lane=3.0, across=2.4)
    found = limit_train(bridge, train=train, fill=FILL, steps=4, options=quick)
    table = found.by_hand()
    (deep,) = found.axles()["fill_below"]
    share = 1.0 / (2.4 + deep)
    assert table["vertical"][0] == pytest.approx(1e4 * share)
    assert table["load"][1] == pytest.approx(3e4 * np.ptp(found.line, axis=1).sum())
    borne = table["vertical"][1] / table["load"][1]
    assert 1.0 / (3.0 + 1.95) < borne < 1.0 / (3.0 + 0.3)
    assert table["vertical"][2] == pytest.approx(table["vertical"][:2].sum())
    assert "beyond the ends of the bridge" in table["of"][-1]
    assert table["vertical"][3:].sum() == pytest.approx(table["vertical"][2])
    whole = limit_train(bridge, train=AXLE, fill=FILL, steps=3, options=quick).by_hand()
    assert whole["vertical"] == pytest.approx([1e5, 1e5, 1e5, 0.0])


@pytest.mark.parametrize("between", [None, (3.3, 6.7)])
@pytest.mark.parametrize("law", ["even", "boussinesq"])
def test_an_axle_counts_on_its_effective_width_however_wide_the_bridge_is(
    between: tuple[float, float] | None, law: Literal["even", "boussinesq"]
) -> None:
    """A ring 10 m wide bore an axle whole, three times what its strip of 1 m bears.

    At the crown, with 0.4 m of fill: 2.4 m + 2 * 0.5 * 0.4 m = 2.8 m.
    """
    fill = Fill(0.4, 19e3, law=law)
    narrow, wide = (segmental_bridge(8.0, 2.0, 0.5, 13, width=w) for w in (1.0, 10.0))
    strip, tops = Tops.of(narrow, fill), Tops.of(wide, replace(fill, between=between))
    effective, breadth = tops.effective(np.array([4.0]), 0.4, 2.4)
    assert (*effective, *breadth) == pytest.approx((2.8, 10.0), rel=3e-3)
    one, ten = (each.spread(1e3, np.array([2.0]), 0.4, 2.4)[0] for each in (strip, tops))
    assert ten[:, :3] == pytest.approx(10.0 * one[:, :3])
    assert ten[:, 4] == pytest.approx(10.0 * one[:, 4])


@pytest.mark.parametrize("law", ["even", "boussinesq"])
def test_axles_side_by_side_follow_the_skew(law: Literal["even", "boussinesq"]) -> None:
    """All at one x across, LM1 on 10 m at 35 degrees had the factor 6.27; a strip has 1.53."""
    ring, shear = segmental_bridge(8.0, 2.0, 0.5, 13, width=10.0), np.eye(3)
    shear[0, 1] = np.tan(np.radians(35.0))
    skew = Assembly([Block(b.vertices @ shear.T, b.faces, b.name) for b in ring.blocks], ring.fixed)
    square, skewed = (Tops.of(one, Fill(0.4, 19e3, law=law)) for one in (ring, skew))
    assert skewed.road.skew == pytest.approx(shear[0, 1])
    each = (square, np.array([2.0])), (skewed, np.array([2.0 + 5.0 * shear[0, 1]]))
    one, other = (t.spread(1e3, x, 0.4, 2.4)[0, :, 2] for t, x in each)
    assert other == pytest.approx(one, abs=0.06 * np.abs(one).max())


def test_nothing_spreads_beyond_the_parapets_of_a_bridge() -> None:
    """3 m between faces: an axle of 2.4 m counts on 2.8 m at the crown, and on all 3 m below."""
    ring = segmental_bridge(8.0, 2.0, 0.5, 13, width=3.0)
    walls = [box((8.0, 0.3, 2.9), (0.0, y, 0.0), f"y={y}") for y in (0.0, 2.7)]
    for between in ((0.3, 2.7), None):  # is held by walls, or said to end
        blocks = ring.blocks if between else (*ring.blocks, *walls)
        assembly = Assembly(blocks, [*ring.fixed.tolist(), *[False] * (len(blocks) - len(ring))])
        tops = Tops.of(assembly, Fill(0.4, 19e3, between=between))
        assert tops.whole
        assert np.ravel(tops.effective(np.array([1.0]), 0.4, 2.4)) == pytest.approx((3.0, 3.0))
    assert not Tops.of(ring, Fill(0.4, 19e3)).whole


@pytest.mark.parametrize("name", ["axle", "lm71"])
def test_few_places_and_many_find_the_same_worst_one(bridge: Model, name: str) -> None:
    quick = LimitOptions(equilibrium_only=True)
    few, many = (
        limit_train(bridge, train=Train.named(name), fill=FILL, steps=steps, options=quick)
        for steps in (21, 90)
    )
    assert (np.diff(few.places) > 0.0).all()
    assert few.factors[few.worst] == pytest.approx(many.factors[many.worst], rel=3e-3)


def test_an_axle_at_the_end_that_no_factor_ends_is_asked_no_more() -> None:
    backed = Model.of(segmental_bridge(span=8, rise=2, ring=0.5, voussoirs=10, backing=0.6))
    train, quick = Train("narrow", (0.0, 1.2), (3e5, 3e5), 0.4), LimitOptions(equilibrium_only=True)
    fill = Fill(cover=0.4, weight=1.9e4, k=0.3)
    few, many = (
        limit_train(backed, train=train, fill=fill, steps=steps, options=quick, time_limit_s=20)
        for steps in (2, 20)
    )
    assert many.factors[0] == np.inf
    assert many.factors.min() == pytest.approx(few.factors.min(), rel=1e-6)


def test_what_carries_much_more_is_marked_at_the_upper_edge_of_the_chart(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, fill=FILL, steps=9, options=quick)
    marks = found.figure().marks
    drawn = np.concatenate([one.y for one in marks])
    assert np.isfinite(drawn).all()
    assert 0.0 < drawn.max() <= 4.0 * found.factors.min()
    line, rings = marks[0], marks[-1]
    assert line.x.tolist() == found.places.tolist()
    assert rings.kind.value == "ring"
    assert 0 < len(rings.x) < len(found.places)
    assert rings.x.tolist() == found.places[found.factors > drawn.max()].tolist()


def test_a_verdict_that_is_stopped_is_not_known_while_the_factor_of_forces_is(
    bridge: Model,
) -> None:
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, train=AXLE, steps=2, options=quick)
    late = limit_load(bridge, found.live(0.0), time_limit_s=0.0)
    told = replace(found, limit=late, stopped=late.stopped).sentences()
    said = [one.text for one in told]
    assert (said[0].startswith("Forces balance"), told[0].role) == (True, Role.BAD)
    assert "No verdict is known yet" in said
    assert [one for one in said if "not finished" in one] == ["not finished: the time was up"]


@pytest.mark.parametrize("last", [1, 2, 3])
def test_whenever_a_search_is_stopped_it_says_so(bridge: Model, last: int) -> None:
    """Before the place, beside it, and before a verdict."""
    asked = count(1)
    found = limit_train(bridge, train=AXLE, steps=1, stop=lambda: next(asked) >= last)
    assert found.limit is None
    assert found.stopped == "it was interrupted"


def test_a_bridge_that_falls_alone_carries_no_train_anywhere() -> None:
    model = Model.of(segmental_bridge(voussoirs=8), friction=0.05)
    found = limit_train(model, train=Train.named("lm1"), steps=3)
    assert found.title == "Falls without 'lm1'"
    assert found.limit is None
    assert set(found.numbers()["carries"]) == {"none (falls without the train)"}
    assert not any("inf" in one.text for one in found.sentences())
    assert found.layers().title == found.figure().caption == found.title
    assert "unlimited" not in str(found.table())


def test_what_is_carried_whatever_the_factor_is_told_apart_from_none() -> None:
    found = limit_train(tower(3), train=Train("axle", (0.0,), (1e5,)), steps=1)
    assert found.carries == ("any factor",)
    assert found.sentences()[0].role is Role.GOOD


def test_a_bridge_turned_in_plan_carries_the_same_along_its_road() -> None:
    """Along x a bridge at 30 degrees bore twice as much, and one at 90 degrees any factor."""
    bridge, fill = segmental_bridge(voussoirs=7), Fill(cover=0.3, weight=2e4, k=0.3)
    train, quick = Train.named("lm1"), LimitOptions(equilibrium_only=True)
    turns = rotations(np.radians([[0.0, 0.0, 0.0], [0.0, 0.0, 30.0], [0.0, 0.0, 90.0]]))
    one, *others = (
        limit_train(bridge.transformed(turn), train=train, fill=fill, steps=2, options=quick)
        for turn in turns
    )
    for other in others:
        assert other.factors == pytest.approx(one.factors, rel=1e-6)
        assert other.axles()["borne"] == pytest.approx(one.axles()["borne"])
        assert any(text.text.startswith("the road is taken along") for text in other.sentences())


def test_the_answer_names_the_fill_the_axles_and_what_the_standard_adds(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, train=Train.named("lm71"), fill=FILL, steps=1, options=quick)
    told = "; ".join(one.text for one in found.sentences())
    assert "250 kN at 1.6 m" in told
    assert "fill of 20 kN/m3 to 0.3 m above the crown with K 0" in told
    assert "a load spreads 0.5 by depth" in told
    assert "80 kN/m along x on a width of 2.6 m, where it is adverse from 0.8 m beside" in told
    assert "line load at the worst place: it acts at x = " in told
    assert "without a dynamic factor" in told
    (width,) = [one for one in found.sentences() if one.text.startswith("the answer is for all")]
    assert width.role is Role.REMARK
    assert "model, 1 m wide: it bears, by its width over the effective one of" in width.text
    assert " of the line load, as a strip of a wider bridge: if this is the whole" in width.text
    assert "x of the middle of the train; the bridge lies from -0.36 to 6.36 m" in told
    assert "a wheel alone may be worse" in told
    assert "at a kerb an axle spreads to one side only: give 'across' less" in width.text
    lane = replace(AXLE, across=0.5, line=1e3, lane=0.5)
    held = replace(FILL, between=(0.0, 1.0))
    deep = limit_train(bridge, train=lane, fill=held, steps=1, options=quick)
    words = "; ".join(one.text for one in deep.sentences())
    assert "add 67 and 33 % of the axles and 28 % each" in words
    borne = found.axles()["borne"]
    wide = 2.6 + 2.0 * 0.5 * found.axles()["fill_below"]
    assert borne == pytest.approx(1.0 / wide)
    assert "along y than" not in told


def test_parts_of_faces_that_crush_are_kept_for_the_next_stretch_of_a_line_load(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With mortar, which no plane program has: 16 programs a stretch if each begins anew."""
    solved, asked = [], []
    solve, largest = ConicProgram.solve, LoadFactors.__call__
    monkeypatch.setattr(ConicProgram, "solve", lambda *a, **k: solved.append(0) or solve(*a, **k))
    monkeypatch.setattr(LoadFactors, "__call__", lambda *a: asked.append(0) or largest(*a))
    stone = {"tension": 5e4, "cohesion": 1e5, "compression": 5e6}
    small = Model.of(segmental_bridge(voussoirs=4), friction=0.6)
    mortar = small.with_capacity(JointCapacity.of_stress(small.contacts, **stone))
    quick = LimitOptions(equilibrium_only=True)
    limit_train(mortar, train=Train.named("lm1"), fill=FILL, steps=1, options=quick)
    assert len(asked) > 4
    assert len(solved) < 8 * len(asked)


def test_places_compared_with_ductile_joints_are_told_where_mortar_is_brittle(
    bridge: Model,
) -> None:
    mortar = JointCapacity.of_stress(bridge.contacts, tension=1e5)
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge.with_capacity(mortar), fill=FILL, steps=1, options=quick)
    for said in (found.title, found.table().title, found.figure().title):
        assert "with ductile joints" in said
    assert any("other places may carry less" in one.text for one in found.sentences())


def test_workers_find_the_same(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    with ThreadPoolExecutor(2) as executor:
        both = [
            limit_train(bridge, fill=FILL, steps=4, options=quick, executor=one).factors
            for one in (None, executor)
        ]
    assert both[0].tolist() == both[1].tolist()


def test_a_train_of_ones_own_is_read_and_its_axles_keep_their_distance(tmp_path: Path) -> None:
    path = tmp_path / "cart.toml"
    path.write_text('contact = "200mm"\naxles = ["1.5t at 0m", "20kN at 1500mm"]\n', "utf-8")
    cart = Train.named(str(path))
    assert cart.places == (0.0, 1.5)
    assert cart.loads == pytest.approx((1500.0 * 9.81, 2e4))
    assert cart.contact == 0.2


def test_the_command_draws_the_envelope(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["models", "segmental-bridge", "--set", "voussoirs=8", "--out", "b.json"]) == 0
    words = "limit train b.json --steps 1 --html b.html --film b.gif".split()  # noqa: SIM905
    assert main([*words, "--fill", "cover=0.3m,weight=20kN/m3"]) == 2
    assert "film: one stage is no film" in capsys.readouterr().err
    words = "limit train b.json --train lm1 --steps 3 --html b.html".split()  # noqa: SIM905
    fill = "cover=0.3m,weight=20kN/m3"
    assert main([*words, "--fill", fill, "--out", "under.json"]) == 0
    assert "Stands under 'lm1' up to load factor" in capsys.readouterr().out
    assert "Largest load factor" in Path("b.html").read_text("utf-8")
    under = read("under.json")
    assert " + lm1 at x = " in under.load.name
    assert re.match(r"'lm1' stands at x = .* alone: what holds that may fall", under.notes[-1])


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"train": Train("long", (0.0, 9.0), (1e3, 1e3))}, "'long' is 9 m long, the bridge 6.72 m"),
        ({"steps": 0}, "0 places"),
        ({"load": "fill:cover=0.1m,weight=20kN/m3", "fill": FILL}, "--case weight leaves out"),
    ],
)
def test_what_cannot_cross_is_told(bridge: Model, given: dict[str, object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        limit_train(bridge, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('axles = ["300 at 0m"]', "'300' is not a number with a unit; write '300kN at 1.2m'"),
        ('axles = ["300kN"]', "axle '300kN' has no place"),
        ('axles = ["-3kN at 0m"]', "not above zero"),
        ('axles = ["3kN at 2m", "3kN at 0m"]', "its places do not grow"),
        ('axle = ["3kN at 2m"]', "'axle' is no key"),
        ("axles = [", "is not TOML"),
        ('axles = ["1kN at 0m"]\nline = "80kN"', "'80kN' has no unit; write line = '80kN/m'"),
        ('axles = ["1kN at 0m"]\nline = "9kN/m2"', "'9kN/m2' has another unit; write line ="),
        ('axles = ["1kN at 0m"]\nline = "9kN/mm"', "'9kN/mm' has another unit; write line"),
        ('axles = ["1kN at 0m"]\nline = "-1kN/m"', "line is -1000"),
        ('axles = ["1kN at 0m"]\nlane = "3m"', "it has no line load, but a lane"),
        ('axles = ["1kN at 0m"]\ncontact = 300', "length '300' is not a number with a unit"),
        ('axles = ["1kN at 0"]', "length '0' is not a number with a unit"),
    ],
)
def test_a_train_that_cannot_be_read_is_told_in_one_line(
    text: str, told: str, tmp_path: Path
) -> None:
    path = tmp_path / "train.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(InputError, match=told):
        Train.named(str(path))


@pytest.mark.parametrize("train", [replace(AXLE, across=2.4), Train.named("lm1")])
def test_ground_beside_a_bridge_carries_nothing_of_a_train(train: Train) -> None:
    """A fixed slab below it, 4 m wider, changes neither the breadth nor the factor."""
    bridge, fill = segmental_bridge(5.0, 1.5, voussoirs=8), Fill(cover=0.4, weight=19e3, k=0.3)
    low, high = bridge.bounds.reshape(-1, 3).min(axis=0), bridge.bounds.reshape(-1, 3).max(axis=0)
    size = high - low + (2.0, 4.0, 0.0)
    slab = box((size[0], size[1], 0.5), (low[0] - 1.0, low[1] - 2.0, low[2] - 0.5), "slab")
    wide = Assembly((*bridge.blocks, slab), [*bridge.fixed.tolist(), True])
    alone, beside = (limit_train(one, train=train, fill=fill, steps=2) for one in (bridge, wide))
    assert beside.factors == pytest.approx(alone.factors, rel=1e-6)
    assert beside.limit.stands == pytest.approx(alone.limit.stands, rel=1e-6)


def test_the_load_behind_a_free_abutment_is_told_with_the_option_to_type() -> None:
    """9 kN/m2 of load model 1, and its abutment on the left is fixed."""
    left, right = (box((1.0, 1.0, 3.0), (x, 0.0, 0.0), f"at {x:g}") for x in (0.0, 3.0))
    foot = box((4.0, 1.0, 0.5), (0.0, 0.0, -0.5), "foot")
    beam = box((4.0, 1.0, 0.5), (0.0, 0.0, 3.0), "beam")
    bridge = Assembly((foot, left, right, beam)).with_fixed([0, 1])
    found = limit_train(bridge, train=Train.named("lm1"), steps=1)
    (told,) = [one.text for one in found.sentences() if "behind free abutments" in one.text]
    assert "(side x)" in told
    assert told.endswith("--load earth:side=x,weight=0kN/m3,k=0.3,surcharge=9kPa")


def test_an_axle_on_a_bare_ring_does_not_spread() -> None:
    """It is a force on the voussoir below it, at any height."""
    bridge = Model.of(segmental_bridge(voussoirs=10), friction=0.6)
    quick = LimitOptions(equilibrium_only=True)
    axle = Train("axle", (0.0,), (1e3,))
    found = limit_train(bridge, train=axle, steps=3, options=quick)
    alone = limit_load(bridge, f"voussoir-01:1kN@{found.places[0]},0.5,0.5", options=quick)
    assert found.factors[0] == pytest.approx(alone.best.stands, rel=1e-3)
