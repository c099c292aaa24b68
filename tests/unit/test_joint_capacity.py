"""Capacities of joints: made, kept in files, carried along, given on the command line, refused."""

import json

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, JointCapacity, Model, plan
from drystone.cli.application import main
from drystone.joint_capacity import NO_LIMIT
from drystone.models import arch, box, h_model, tower

MODEL = Model.of(tower(4), friction=0.6)


def test_stresses_are_forces_by_area_and_cohesion_follows_tension():
    found = JointCapacity.of_stress(MODEL.contacts, tension=[1.0, 2.0, 3.0], shear=5.0)
    assert found.tension == pytest.approx(MODEL.contacts.area * [1.0, 2.0, 3.0])
    assert found.cohesion == pytest.approx(0.6 * found.tension)
    assert found.shear == pytest.approx(5.0 * MODEL.contacts.area)


def test_corners_share_the_capacity_of_their_interface():
    model = MODEL.with_capacity(JointCapacity.of(MODEL.contacts, tension=8.0, cohesion=12.0))
    tension, cohesion, shear = model.contacts.corner_capacity
    assert tension == pytest.approx(2.0)
    assert cohesion == pytest.approx(3.0)
    assert (shear == np.inf).all()


def test_capacities_follow_a_part_of_the_model():
    model = MODEL.with_capacity(JointCapacity.of(MODEL.contacts, tension=[1.0, 2.0, 3.0]))
    part = model.subset([2, 3])
    assert part.contacts.capacity.tension.tolist() == [3.0]
    assert model.with_friction(0.3).contacts.capacity is model.contacts.capacity
    assert MODEL.contacts.dry.all()
    assert not part.contacts.dry.any()


def test_who_follows_dry_joints_only_refuses_others():
    glued = MODEL.with_capacity(JointCapacity.of(MODEL.contacts, tension=1.0))
    for work in (drystone.settle, drystone.settlement.push):
        with pytest.raises(InputError, match="takes dry joints only"):
            work(glued)


@pytest.mark.parametrize("suffix", [".json"])
def test_a_file_keeps_them(tmp_path, suffix):
    capacity = JointCapacity.of(
        MODEL.contacts, tension=[0.1, 0.2, 0.0], shear=7.0, compression=9.0, brittle=False
    )
    drystone.write(MODEL.with_capacity(capacity), tmp_path / f"glued{suffix}")
    again = drystone.read(tmp_path / f"glued{suffix}").contacts.capacity
    for name in ("tension", "cohesion", "shear", "compression"):
        assert (getattr(again, name) == getattr(capacity, name)).all()
    assert again.law == "ductile"
    drystone.write(MODEL, tmp_path / "dry.json")
    assert drystone.read(tmp_path / "dry.json").contacts.capacity is None


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: JointCapacity([-1.0], [0.0]), "the tension of interface 0 is -1.0"),
        (lambda: JointCapacity([1.0], [float("nan")]), "the cohesion of interface 0 is nan"),
        (lambda: JointCapacity([1.0], [0.0, 1.0]), r"cohesion is \[0.0, 1.0\], not a number$"),
        (
            lambda: JointCapacity.of(MODEL.contacts, tension="x"),
            "tension is 'x', not a number, nor 3 numbers",
        ),
        (lambda: MODEL.with_capacity(JointCapacity([1.0], [1.0])), "3 interfaces and 1 capacities"),
        (lambda: MODEL.with_capacity(3.0), r"capacity is 3.0; give JointCapacity\("),
    ],
)
def test_bad_capacities_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()


@pytest.mark.parametrize(
    "analysis", [drystone.settle, drystone.solve_cra, drystone.solve_cra_penalty]
)
def test_analyses_of_dry_joints_refuse_others(analysis):
    with pytest.raises(InputError, match="takes dry joints only"):
        analysis(MODEL.with_capacity(JointCapacity.of(MODEL.contacts, tension=1.0)))


def test_a_plan_needs_no_help_where_glue_holds():
    """The voussoirs of an arch need props; glued strongly each of them stands alone."""
    model = Model.of(arch(0.3, 5), friction=0.4)
    glue = JointCapacity.of(model.contacts, tension=NO_LIMIT, cohesion=NO_LIMIT)
    assert plan(model).counts["free"] < 5
    glued = plan(model.with_capacity(glue))
    assert glued.counts["free"] == len(model.assembly.free)
    assert all(step.answer.stands for step in glued.steps)


def test_a_joint_without_strength_is_refused_and_edges_have_none():
    with pytest.raises(InputError, match="strength in compression of interface 1 is 0"):
        JointCapacity.of_stress(MODEL.contacts, compression=[1.0, 0.0, 1.0])
    weak = MODEL.with_capacity(JointCapacity.of_stress(MODEL.contacts, compression=1e4))
    assert weak.contacts.crushes.all()
    assert weak.contacts.dry.all()
    assert not weak.contacts.plain.any()
    with pytest.raises(InputError, match="takes dry joints only"):
        drystone.settle(weak)


def test_the_command_line_crushes(overhang, capsys):
    """Three cubes of 23,544 N press on 1 m2."""
    drystone.write(tower(4), overhang / "tower.json")
    assert main(["check", "tower.json", "--joint-capacity", "compression=71kPa"]) == 0
    capsys.readouterr()
    assert main(["check", "tower.json", "--joint-capacity", "compression=70kPa"]) == 1
    assert "crushes" in capsys.readouterr().out
    assert main(["check", "tower.json", "--joint-capacity", "compression=0.1MPa", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["strength_use"] == pytest.approx(0.70632, rel=1e-4)
    assert told["crushing_factor"] == pytest.approx(1.0 / 0.70632, rel=1e-4)
    assert any("strength: the joint of" in one for one in told["sentences"])


def test_utilisation_counts_the_cohesion():
    assembly = tower(2)
    load = drystone.LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 20.0)
    model = Model.of(assembly, friction=0.6, load=load)
    dry = drystone.check(model)
    assert dry.utilisation == pytest.approx([np.tan(np.deg2rad(20.0)) / 0.6])
    weight = np.linalg.norm(model.load.wrench[1, :3])
    more = 0.4 * weight * np.cos(np.deg2rad(20.0))
    glued = drystone.check(model.with_capacity(JointCapacity.of(model.contacts, cohesion=more)))
    assert glued.utilisation == pytest.approx([np.tan(np.deg2rad(20.0)) / 1.0])


@pytest.fixture
def overhang(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    from drystone.models import box

    blocks = (box((1.0, 1.0, 1.0), name="pier"), box((2.5, 1.0, 0.3), (0.0, 0.0, 1.0), "slab"))
    drystone.write(drystone.Assembly(blocks, [True, False]), tmp_path / "overhang.json")
    return tmp_path


def test_the_command_line_takes_stresses_and_a_table(overhang, capsys):
    """Weight 17,658 N at 0.25 m beyond the edge; the pier's other edge is 1 m from it."""
    assert main(["check", "overhang.json"]) == 1
    assert main(["check", "overhang.json", "--joint-capacity", "tension=0.01MPa,ductile"]) == 0
    assert main(["check", "overhang.json", "--joint-capacity", "tension=0.008MPa,ductile"]) == 1
    (overhang / "joints.csv").write_text(
        "block_a,block_b,tension,cohesion,shear\rslab,pier,1e999,10000,\r"  # old line ends
    )
    capsys.readouterr()
    assert main(["check", "overhang.json", "--joint-capacity", "joints.csv,ductile", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "stable"


def test_a_limit_of_moment_is_one_of_tension(overhang):
    """The corners are 0.5 m sqrt(2) from the centroid; a tension T resists T 0.5 m here."""
    assert main(["check", "overhang.json", "--joint-capacity", "moment=6.3kNm,ductile"]) == 0
    assert main(["check", "overhang.json", "--joint-capacity", "moment=6.2kNm,ductile"]) == 1
    assert (
        main(["check", "overhang.json", "--joint-capacity", "moment=1MNm,tension=8kN,ductile"]) == 1
    )
    glue = JointCapacity.of(MODEL.contacts, moment=[1.0, 2.0, 0.0])
    np.testing.assert_allclose(glue.tension * np.sqrt(0.5), [1.0, 2.0, 0.0])
    np.testing.assert_allclose(glue.cohesion, MODEL.contacts.friction * glue.tension)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("compression=0MPa", ["compression is 0", "give more than zero"]),
        ("compression=-5MPa", ["compression is -5e+06"]),
        ("compression=5", ["compression '5'", "unit"]),
        ("compression=5MPa,compression=2MPa", ["'compression=2MPa' is no capacity"]),
        ("crush.csv", ["crush.csv, line 2", "compression is 0"]),
        ("ductile", ["'' is no capacity"]),
        ("compression=5MPa,brittle", ["has no mortar that breaks or yields", "give tension"]),
        ("tension=1kPa,brittle,ductile", ["'brittle' is no capacity"]),
        ("moment=3kN", ["unit 'kN' is not known", "use one of Nm"]),
        ("tension", ["--joint-capacity", "'tension' is no capacity"]),
        ("pull=3Pa", ["'pull=3Pa' is no capacity"]),
        ("tension=3", ["tension '3'", "unit"]),
        ("tension=-3Pa", ["the tension of interface 0 is -3"]),
        ("absent.csv", ["absent.csv"]),
        ("bad.csv", ["bad.csv, line 2", "names no block"]),
        ("lower.csv", ["lower.csv, line 2", "tension '-1' is no number from 0 on"]),
        ("long.csv", ["long.csv: is no table", "save it as CSV"]),
        ("twice.csv", ["twice.csv, line 3", "names the joint of line 2 again; give it once"]),
        ("least.csv", ["least.csv", "interface 0 is 1e-320; give newtons: zero, or 1e-100"]),
    ],
)
def test_bad_capacities_on_the_command_line_are_one_line(overhang, capsys, text, words):
    head = "block_a,block_b,tension,cohesion,shear"
    (overhang / "bad.csv").write_text(f"{head}\na,pier,1,1,\n")
    (overhang / "crush.csv").write_text("block_a,block_b,compression\nslab,pier,0\n")
    (overhang / "lower.csv").write_text(f"{head}\nslab,pier,-1,1,\n")
    (overhang / "twice.csv").write_text(f"{head}\nslab,pier,1,1,\npier,slab,1,1,\n")
    (overhang / "least.csv").write_text(f"{head}\nslab,pier,1e-320,1,\n")
    (overhang / "long.csv").write_text(f"{head}\n{'a' * 200_000}")
    assert main(["check", "overhang.json", "--joint-capacity", text]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert all(word in err for word in words)


@pytest.mark.parametrize("strength", [16e3, 32e3])
def test_glue_that_is_strong_enough_holds_for_every_contact_stiffness(strength):
    model = Model.of(h_model(), friction=0.9)
    contacts = model.contacts
    one = (contacts.block_a == contacts.block_a[0]) & (contacts.block_b == contacts.block_b[0])
    glue = np.where(one, strength, 0.0)
    found = drystone.check(
        model.with_capacity(JointCapacity.of(contacts, tension=glue, cohesion=glue, brittle=False)),
        options=drystone.CheckOptions.robust(),
    )
    assert found.samples.standing == found.samples.tried == 5


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ({"strength": "0.1MPa"}, "compression 0.1 MPa"),
        ({"joint_capacity": "tension=3kN,ductile"}, "tension 3000 N, cohesion 1800 N (ductile)"),
        ({"joint_capacity": "cohesion=0.2MPa"}, "cohesion 0.2 MPa (brittle)"),
    ],
)
def test_what_is_asked_tells_a_stress_where_it_is_one(how, told):
    sizes = enumerate((1.0, 0.5) if "tension" in str(how) else (1.0, 0.5, 0.25))
    blocks = [box((1.0, y, 1.0), (0.0, 0.0, z), f"{z}") for z, y in sizes]
    found = drystone.check(Assembly(tuple(blocks)).with_fixed(["0"]), friction=0.6, **how)
    assert found.asked.facts()["Joint capacity"] == told
