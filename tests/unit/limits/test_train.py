"""Trains over bridges: the envelope, what fill resists, workers, files, and what is refused."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drystone import InputError, JointCapacity, Model, check
from drystone.answer import Role
from drystone.cli import main
from drystone.limits import LimitOptions, limit_load, limit_train
from drystone.loads import Fill, Train
from drystone.models import segmental_bridge

FILL = Fill(cover=0.3, weight=2e4)


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
    live = found.live(float(found.places[found.worst]))
    for factor, stands in ((found.limit.stands, True), (found.limit.falls, False)):
        assert factor is not None
        assert check(found.model.with_load(found.model.load + factor * live)).stable is stands


def test_what_fill_resists_helps_and_is_bounded(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    factors = []
    for passive in (0.0, 0.5, 2.0, 1e6):
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


def test_a_train_with_a_heavy_end_is_moved_both_ways(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    cart = Train("cart", (0.0, 2.0), (1e3, 5e3))
    assert cart.turned.loads == (5e3, 1e3)
    found = limit_train(bridge, train=cart, fill=FILL, steps=4, options=quick)
    other = limit_train(bridge, train=cart.turned, fill=FILL, steps=4, options=quick)
    assert found.factors == pytest.approx(other.factors)
    assert found.factors == pytest.approx(found.factors[::-1], rel=1e-6)


def test_what_carries_much_more_is_no_part_of_the_lines_of_the_chart(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, fill=FILL, steps=9, options=quick)
    marks = found.figure().marks
    drawn = np.concatenate([one.y for one in marks])
    assert np.isfinite(drawn).all()
    assert 0.0 < drawn.max() <= 4.0 * found.factors.min()
    assert sum(len(one.x) for one in marks[:-1]) < 9


def test_a_bridge_that_falls_alone_carries_no_train_anywhere() -> None:
    model = Model.of(segmental_bridge(voussoirs=8), friction=0.05)
    found = limit_train(model, train=Train.named("lm1"), steps=3)
    assert found.title == "Falls without 'lm1'"
    assert found.limit is None
    assert set(found.numbers()["carries"]) == {"none (falls without the train)"}
    assert not any("inf" in one.text for one in found.sentences())
    assert found.layers().title == found.figure().caption == found.title
    assert "unlimited" not in str(found.table())


def test_what_is_carried_whatever_the_factor_is_told_apart_from_none(bridge: Model) -> None:
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    along_y = Model.of(bridge.assembly.transformed(turned), friction=0.6)
    found = limit_train(along_y, steps=1)
    assert found.carries == ("any factor",)
    assert found.sentences()[0].role is Role.UNSURE
    assert "longer along y than along x" in found.sentences()[1].text


def test_the_answer_names_the_fill_the_axles_and_what_the_standard_adds(bridge: Model) -> None:
    quick = LimitOptions(equilibrium_only=True)
    found = limit_train(bridge, train=Train.named("lm71"), fill=FILL, steps=1, options=quick)
    told = "; ".join(one.text for one in found.sentences())
    assert "250 kN at 1.6 m" in told
    assert "fill of 20 kN/m3 to 0.3 m above the crown with K 0" in told
    assert "a load spreads 0.5 by depth" in told
    assert "without its 80 kN/m, and without a dynamic factor" in told
    assert "along y than" not in told


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
    words = "limit train b.json --train lm1 --steps 3 --html b.html".split()  # noqa: SIM905
    assert main([*words, "--fill", "cover=0.3m,weight=20kN/m3"]) == 0
    assert "Stands under 'lm1' up to load factor" in capsys.readouterr().out
    assert "Largest load factor" in Path("b.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"train": Train("long", (0.0, 9.0), (1e3, 1e3))}, "'long' is 9 m long, the bridge 6.72 m"),
        ({"steps": 0}, "0 places"),
        ({"load": "fill:cover=0.1m,weight=20kN/m3"}, "has fill already"),
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
        ("axles = [", "is no TOML"),
    ],
)
def test_a_train_that_cannot_be_read_is_told_in_one_line(
    text: str, told: str, tmp_path: Path
) -> None:
    path = tmp_path / "train.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(InputError, match=told):
        Train.named(str(path))
