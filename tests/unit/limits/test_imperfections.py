"""Studies of imperfections: tolerances, orders of loading, intervals, tables and plots."""

import json
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import InputError, LoadCase, Model, Verdict
from drystone.cli import main
from drystone.limits import Imperfections, StandingShare, imperfect, imperfections
from drystone.mechanics.corners import Carrier, joint_ends
from drystone.models import incline, tower, wedge
from drystone.settlement import Loading, SettlementOptions, settle

Capsys = pytest.CaptureFixture[str]
ORDERS = ("at once", "ramp", "turned")
FRICTION = Imperfections(friction_range=(0.3, 0.5))


def slope(angle: float) -> Model:
    """A block on a plane that is tilted by the load."""
    block = incline(0.0)
    return Model.of(block, load=LoadCase.tilt(block, (0.0, 1.0, 0.0), angle))


@pytest.fixture(scope="module")
def study() -> StandingShare:
    # stands where its friction is above tan(22 degrees) = 0.404: about half of the draws
    return imperfections(slope(22.0), FRICTION, draws=4, seed=5, loading=ORDERS)


def test_each_draw_is_followed_in_every_order_and_all_agree_on_a_slope(
    study: StandingShare,
) -> None:
    assert study.loading == tuple(Loading)
    assert study.draws == 4
    table = study.table()
    for order in ORDERS:
        mine = table["loading"] == order
        np.testing.assert_array_equal(
            table["stands"][mine], table["friction"][mine] > np.tan(np.deg2rad(22.0))
        )
    assert 0 < study.share < 1
    for row in study.by_loading():
        assert row["share"] == study.share
        assert 0.0 <= row["low"] < row["share"] < row["high"] <= 1.0


def test_a_draw_counts_once_whatever_the_number_of_orders(study: StandingShare) -> None:
    # the verdicts of one draw depend on each other: as draws of their own the interval is too short
    for row in study.by_loading():
        assert (study.share, *study.interval) == (row["share"], row["low"], row["high"])
    verdicts = (Verdict.STABLE, Verdict.UNSTABLE, Verdict.STABLE, Verdict.UNDECIDED,
                Verdict.STABLE, Verdict.STABLE, Verdict.UNDECIDED, Verdict.UNSTABLE)  # fmt: skip
    orders = (Loading.AT_ONCE, Loading.RAMP)
    mixed = StandingShare(verdicts, 0.25, (0.0, 1.0), 0.95, orders, np.zeros(4),
                          model=Model.of(tower(2)), options=Imperfections())  # fmt: skip
    assert mixed.by_draw == (False, None, True, False)
    told = mixed.to_dict()
    assert (told["draws"], told["standing"], told["undecided"]) == (4, 1, 1)


def test_the_same_seed_gives_the_same_study_with_an_executor(study: StandingShare) -> None:
    with ThreadPoolExecutor(2) as executor:
        again = imperfections(
            slope(22.0), FRICTION, draws=2, seed=5, loading=ORDERS, executor=executor
        )
    assert again.verdicts == study.verdicts[:6]
    np.testing.assert_array_equal(again.friction, study.friction[:2])
    other = imperfections(slope(22.0), FRICTION, draws=1, seed=6, loading="at once")
    assert other.friction[0] not in study.friction


def test_it_stops_between_two_draws() -> None:
    asked = partial(imperfections, slope(22.0), FRICTION, draws=3, seed=5, loading="at once")
    told: list[int] = []
    whole = asked(progress=lambda stage, done, total: told.append(done))
    some = asked(stop=lambda: True)
    assert (told, some.draws) == ([1, 2, 3], 1)
    assert some.verdicts == whole.verdicts[:1]
    assert len(some.table()) == 1


def test_a_tolerance_is_the_size_of_what_is_drawn() -> None:
    contacts = Model.of(tower(400, edge=0.5)).contacts
    drawn = imperfect(contacts, Imperfections(tolerance=0.01), 3)
    moved = (drawn.centroid - contacts.centroid)[:, :2]
    assert moved.std() == pytest.approx(0.01, rel=0.1)
    turned = np.arccos(np.clip(drawn.frame[:, 0, 2], -1.0, 1.0))
    # two axes, each by the tolerance over half the side
    assert np.sqrt((turned**2).mean()) == pytest.approx(np.sqrt(2.0) * 0.01 / 0.25, rel=0.1)
    np.testing.assert_allclose(drawn.area, contacts.area, rtol=1e-9)
    with pytest.raises(InputError, match="tolerance is -1"):
        Imperfections(tolerance=-1.0)


@pytest.mark.parametrize("longer", [0.0, 0.2])
def test_imperfect_joints_end_on_the_same_blocks(longer: float) -> None:
    # where the groove is longer than the wedge, its ends are those of the wedge alone
    assembly = wedge("b", longer=longer)
    load = LoadCase.tilt(assembly, (1.0, 0.0, 0.0), 50.0)
    model = Model.of(assembly, friction=0.84, load=load)
    kinds = Imperfections(tolerance=1e-3)
    gap = np.zeros((model.contacts.corner_count, 2))
    for carrier in Carrier:
        nominal = joint_ends(assembly, model.contacts, carrier, gap)
        drawn = joint_ends(assembly, imperfect(model.contacts, kinds, 1), carrier, gap)
        np.testing.assert_array_equal(drawn.share, nominal.share)
    if longer:  # it comes to rest, whichever block carries the other edges
        assert imperfections(model, kinds, draws=2, loading="at once").share == 1.0


@pytest.mark.parametrize("order", list(Loading))
def test_every_order_ends_where_the_slope_is_the_friction(order: Loading) -> None:
    options = SettlementOptions(loading=order)
    friction = float(np.tan(np.deg2rad(31.0)))
    block = incline(0.0)
    for angle, rests in ((30.8, True), (31.2, False)):
        load = LoadCase.tilt(block, (0.0, 1.0, 0.0), angle)
        assert settle(block, load=load, friction=friction, options=options).rests is rests


def test_what_hangs_upside_down_is_turned_all_the_way() -> None:
    model = Model.of(tower(2), load=(0.0, 0.0, 9.81))
    assert not settle(model, options=SettlementOptions(loading=Loading.TURNED)).rests


def test_bad_orders_are_told() -> None:
    with pytest.raises(InputError, match="'at once', 'ramp', 'turned'"):
        imperfections(slope(1.0), FRICTION, loading=["sideways"])
    with pytest.raises(InputError, match="named twice"):
        imperfections(slope(1.0), FRICTION, loading=["ramp", "ramp"])


def test_a_study_is_a_table_plain_values_and_a_plot(study: StandingShare, tmp_path: Path) -> None:
    assert repr(study) == f"StandingShare('{study.title}')"
    assert len(study.to_pandas()) == 12
    told = json.loads(json.dumps(study.to_dict()))
    assert [row["loading"] for row in told["by_loading"]] == list(ORDERS)
    drystone.view.save_figure(study, tmp_path / "share.svg")
    assert "turned" in (tmp_path / "share.svg").read_text(encoding="utf-8")
    checked = imperfections(slope(10.0), FRICTION, draws=2)
    assert checked.verdicts == (Verdict.STABLE, Verdict.STABLE)
    assert checked.table()["loading"].tolist() == ["check", "check"]


def test_the_command_writes_the_draws_and_the_plot(tmp_path: Path, capsys: Capsys) -> None:
    path, table = tmp_path / "slope.json", tmp_path / "draws.csv"
    drystone.write(slope(22.0), path)
    # every coefficient is below tan(22 degrees)
    asked = ["limit", "imperfections", str(path), "--friction-range", "0.2,0.4", "--draws", "3"]
    orders = ["--loading", "at-once", "--loading", "ramp"]
    files = ["--csv", str(table), "--png", str(tmp_path / "share.png")]
    assert main([*asked, *orders, *files]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "0 of 3 imperfect structures stand in every order" in out
    assert "order of loading" in out
    lines = table.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "draw,friction,loading,verdict,stands"
    assert len(lines) == 7
    assert (tmp_path / "share.png").exists()
    assert main(["limit", "imperfections", str(path), "--tolerance", "0.001", "--draws", "1",
                 "--friction", "0.6", "--json"]) == 0  # fmt: skip
    assert json.loads(capsys.readouterr().out)["by_loading"][0]["loading"] == "check"
