"""Combinations of actions: their factors, the one that governs, and what is refused."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import DrystoneError, JointCapacity, LoadCase, Model
from drystone.answer import Role
from drystone.base.settings import Clock
from drystone.cli import main
from drystone.io.opening import as_model
from drystone.limits import LimitOptions, limit_friction
from drystone.models import box, segmental_bridge, tower
from drystone.report import write_report
from drystone.report.document import TitleBlock
from drystone.report.report_sections import document_of
from drystone.studies import combinations, read_combinations
from drystone.ties import with_tie_words

WEIGHT = """
[case.weight]
kind = "permanent"
load = "gravity"
"""
PUSH = """
[case.push]
kind = "variable"
psi = [0.7, 0.5, 0.3]
load = "block-1:{},0,0N"
"""
QUAKE = '[case.quake]\nkind = "seismic"\nload = "seismic:0.1"\n'
OWN = '[[situation]]\nname = "own"\npermanent = [1, 1]\nleading = [1, -1]\nothers = [1, 0]\n'
STACK = Model.of(tower(2), friction=2.0)
"""A cube of 1 m and 23,544 N on a cube."""


def written(folder: Path, *parts: str) -> Path:
    path = folder / "cases.toml"
    path.write_text("\n".join(parts), encoding="utf-8")
    return path


@pytest.mark.parametrize(("force", "stands"), [(14000, True), (14250, False)])
def test_a_block_overturns_where_the_factors_of_equilibrium_say(
    force: float, stands: bool, tmp_path: Path
) -> None:
    """By moments about the edge: 1.5 Q h/2 = 0.9 W b/2, so Q = 14,126 N."""
    path = written(tmp_path, 'situations = ["EQU", "STR"]', WEIGHT, PUSH.format(force))
    found = combinations(STACK, path)
    assert len(found.each) == 8
    governing = found.each[found.governs]
    assert (governing.situation.name, governing.words) == ("EQU", "0.9 weight + 1.5 push")
    assert (found.code == 0) == stands
    assert found.governing.stable == stands
    if stands:
        share = 1.5 * force / (0.9 * 23544.0)
        assert found.needed[found.governs] == pytest.approx(share, abs=2e-3)


@pytest.mark.usefixtures("unpainted")
def test_the_summary_of_a_report_names_the_combination_that_governs(tmp_path: Path) -> None:
    first = 'situations = ["EQU", "STR"]\n[material]\nstrength = 1.5'
    found = combinations(STACK, written(tmp_path, first, WEIGHT, PUSH.format(14250)))
    quick = limit_friction(STACK, options=LimitOptions(equilibrium_only=True))
    parts = document_of([found, quick], TitleBlock()).sections[0].parts
    (told,) = [x for x in parts if "Does" in str(x)]
    assert "governs: EQU: 0.9 weight + 1.5 push. there: " in str(told)
    (whole,) = [x for x in parts if "Material factors" in str(x)]
    assert str(whole).endswith("do not divide friction and strength here.")


@pytest.mark.parametrize("first", [6000, 15000])
@pytest.mark.usefixtures("unpainted")
def test_what_is_stopped_speaks_of_no_more_than_it_checked(first: float, tmp_path: Path) -> None:
    """Of eight combinations the second is not asked; a limit of time is told as one."""
    path = written(tmp_path, 'situations = ["EQU", "STR"]', WEIGHT, PUSH.format(first))
    whole = Clock(60.0)

    def spend(stage: str, done: int, total: int) -> None:
        whole.limit_s = 0.0 if done == 2 else 60.0

    found = combinations(STACK, path, needed_of="none", stop=whole.late, progress=spend)
    fallen = sum(not one.stable for one in found.results)
    said = [one.text for one in found.sentences()]
    assert said[0] == (
        f"Does not stand in {fallen} of the first 2 of 8 combinations"
        if fallen
        else "Stands in the first 2 of 8 combinations"
    )
    assert said[1].startswith("governs of these: EQU: ")
    assert said[-1] == "not finished: the time was up"
    assert (found.code, found.news) == (1, Role.BAD if fallen else Role.UNSURE)
    assert [found.to_dict()[one] for one in ("checked", "asked_for")] == [2, 8]
    parts = str(document_of([found], TitleBlock()).sections[0].parts)
    assert said[0] in parts


@pytest.mark.parametrize("apart", [False, True])
def test_equilibrium_of_a_beam_with_a_wall_on_each_end_needs_both_as_cases(
    apart: bool, tmp_path: Path
) -> None:
    """Walls of W at 1.75 m, a pier 0.1 m to each side: 1.1 W 1.65 > 0.9 W 1.85 + 1.1 B 0.1."""
    pier = box((0.2, 1.0, 1.0), (-0.1, 0.0, 0.0), "pier")
    beam = box((4.0, 1.0, 0.1), (-2.0, 0.0, 1.0), "beam")
    walls = (box((0.5, 1.0, 1.5), (x, 0.0, 1.1), f"{x}") for x in (-2.0, 1.5))
    weight = [WEIGHT.replace("weight", f"w{i}") + f'blocks = "{one}"'
              for i, one in enumerate(("beam", "-2.0", "1.5"))]  # fmt: skip
    path = written(tmp_path, 'situations = ["EQU"]', *(weight if apart else [WEIGHT]))
    model = Model.of(drystone.Assembly([pier, beam, *walls], [True, False, False, False]))
    found = combinations(model, path, needed_of="none")
    told = " ".join(one.text for one in found.sentences())
    said = "EQU takes all of 'weight' by one factor" in told and '[case.NAME] kind = "perm' in told
    assert (found.code == 0, said) == (not apart, not apart)


def test_friction_and_strength_are_divided(tmp_path: Path) -> None:
    """It slides where 1.5 Q = 0.9 W 0.6/1.25, so at Q = 6,781 N."""
    firm = 'situations = ["EQU"]\n[material]\nfriction = 1.25\nstrength = "A2"'
    rough = Model.of(tower(2), friction=0.6)
    for force, stands in ((6700, True), (6850, False)):
        path = written(tmp_path, firm, WEIGHT, PUSH.format(force))
        assert combinations(rough, path, needed_of="none").governing.stable == stands
    glued = STACK.with_capacity(JointCapacity.of(STACK.contacts, tension=1700.0, brittle=False))
    one = read_combinations(path, glued)[0].of(glued)
    assert one.contacts.capacity is not None
    assert one.contacts.capacity.tension.tolist() == pytest.approx([1000.0])
    assert one.contacts.capacity.law == "ductile"
    assert one.contacts.friction.tolist() == pytest.approx([1.6])


def test_a_factor_is_told_with_all_of_its_digits(tmp_path: Path) -> None:
    """1.35 times a psi of 0.75 is 1.0125."""
    own = '[[situation]]\nname = "own"\npermanent = [1, 1]\nleading = [1.35, 0]\nothers = [1, 0]'
    cart = PUSH.format(1).replace("0.7, 0.5, 0.3", "0.75, 0.75, 0")
    (_, one) = read_combinations(written(tmp_path, own, WEIGHT, cart), STACK)
    assert one.words == "1 weight + 1.0125 push"


def test_ties_are_divided_by_a_factor_of_their_own(tmp_path: Path) -> None:
    """That of joints made 9 kN of it 3 kN, and the tie that a wall needs three times as large."""
    held = with_tie_words(STACK, ["block-0:block-1:9kN"])
    for material, pull in (("strength = 3.0", 9e3), ("strength = 3.0\ntie = 1.25", 7.2e3)):
        path = written(tmp_path, f'situations = ["EQU"]\n[material]\n{material}', WEIGHT)
        found = combinations(held, path, needed_of="none")
        assert found.governing.contacts.tie_strength.min() == pytest.approx(pull)
    assert "strength of joints by 3, of ties by 1.25" in str([x.text for x in found.sentences()])
    assert found.tables()[1]["tie_by"].tolist() == [1.25]
    bare = combinations(STACK, path, needed_of="none")
    assert "of ties by 1.25, of which there is none" in str([x.text for x in bare.sentences()])
    used = written(tmp_path, f'situations = ["characteristic"]\n[material]\n{material}', WEIGHT)
    assert combinations(held, used, needed_of="none").tables()[1]["tie_by"].tolist() == [1.0]


def test_what_is_needed_is_told_of_the_size_of_joints_and_of_their_friction(tmp_path: Path) -> None:
    """1.5 x 6 kN by 0.9 W = 0.425 is the slope of the thrust: of half a joint, and of 0.6."""
    path = written(tmp_path, 'situations = ["EQU"]', WEIGHT, PUSH.format(6000))
    found = combinations(Model.of(tower(2), friction=0.6), path)
    slope = 1.5 * 6000.0 / (0.9 * 23544.0)
    size, friction = (found.needs[of][found.governs] for of in ("size", "friction"))
    assert (size, friction) == pytest.approx((slope, slope / 0.6), abs=2e-3)
    assert found.needed[found.governs] == friction
    told = "it needs 42.5% of the size of the joints and 70.9% of the friction: safety 1.41"
    assert told in " ".join(one.text for one in found.sentences())
    assert {"needs_of_size", "needs_of_friction"} < set(found.tables()[0].columns)


def test_what_is_needed_does_not_count_mortar_that_breaks(tmp_path: Path) -> None:
    """As dry, which at 15,000 N it does not balance."""
    glued = STACK.with_capacity(JointCapacity.of(STACK.contacts, tension=1e5))
    firm = 'situations = ["EQU"]'
    found = combinations(glued, written(tmp_path, firm, WEIGHT, PUSH.format(6000)))
    assert found.needed[found.governs] == pytest.approx(1.5 * 6000.0 / (0.9 * 23544.0), abs=2e-3)
    found = combinations(glued, written(tmp_path, firm, WEIGHT, PUSH.format(15000)))
    assert found.code == 0
    assert "what it needs is not known" in " ".join(one.text for one in found.sentences())


def test_variable_actions_lead_in_turn_and_an_earthquake_goes_both_ways(tmp_path: Path) -> None:
    other = '[case.snow]\nkind = "variable"\ncategory = "snow"\nload = "block-1:1kN"'
    quake = '[case.quake]\nkind = "seismic"\nreversible = true\nload = "seismic:0.1"'
    path = written(tmp_path, WEIGHT, PUSH.format(100), other, quake)
    found = read_combinations(path, STACK)
    words = {name: [one.words for one in found if one.situation.name == name]
             for name in ("STR", "seismic")}  # fmt: skip
    assert "1.35 weight + 1.5 push + 0.75 snow" in words["STR"]
    assert "1.35 weight + 1.05 push + 1.5 snow" in words["STR"]
    assert words["seismic"] == [
        f"1 weight {more}{sign} 1 quake" for more in ("", "+ 0.3 push ") for sign in "+-"
    ]
    grouped = read_combinations(
        written(tmp_path, WEIGHT, PUSH.format(100) + 'group = "q"', other + '\ngroup = "q"'), STACK
    )
    assert not any("push" in one.factors and "snow" in one.factors for one in grouped)


@pytest.mark.parametrize(("udl", "stands"), [(7300, True), (7600, False)])
def test_tandem_and_udl_lead_as_one_action(udl: float, stands: bool, tmp_path: Path) -> None:
    """Group gr1a of EN 1991-2, table 4.4a: 1.35 (TS + UDL) h/2 = W b/2, so UDL = 7,440 N."""
    road = "".join(
        PUSH.format(force).replace("push", name).replace("psi = [0.7, 0.5, 0.3]", category)
        for name, force, category in (
            ("ts", 10000, 'category = "tandem"'),
            ("udl", udl, 'psi = [0.4, 0.4, 0]\nfactors = [1.35, 0]\ntogether = "gr1a"'),
            ("crowd", -1, 'category = "footway"'),
        )
    )
    path = written(tmp_path, 'situations = ["STR"]', WEIGHT, road)
    found = combinations(STACK, path, needed_of="none")
    told = {one.words: result.stable for one, result in zip(found.each, found.results, strict=True)}
    assert told["1 weight + 1.35 ts + 1.35 udl"] is stands
    assert told["1 weight + 1.35 ts + 1.35 udl + 0.81 crowd"] is stands
    assert len(told) == 2 * 2**3  # each that is present leads with all others
    words = found.tables()[2]["load"].tolist()
    assert words[1].endswith("; leads with all of gr1a")
    assert words[3].endswith("; leads with all of gr1a, beside them 0.6 of it")
    wind = PUSH.format(1).replace("psi = [0.7, 0.5, 0.3]", 'category = "wind"')
    each = read_combinations(written(tmp_path, 'situations = ["STR"]', WEIGHT, road, wind), STACK)
    assert any(one.words == "1 weight + 1.0125 ts + 0.54 udl + 1.5 push" for one in each)


def test_factors_of_a_permanent_case_replace_those_of_the_situations_that_are_named(
    tmp_path: Path,
) -> None:
    """EQU keeps 0.9 of what holds, 0.9 W b/2 = 1.5 Q h/2 at 14,126 N, and serviceability has 1."""
    own = WEIGHT + "factors = { STR = [1.2, 1.0] }"
    some = 'situations = ["EQU", "STR", "characteristic"]'
    found = combinations(STACK, written(tmp_path, some, own, PUSH.format(14250)), needed_of="none")
    words = [(one.situation.name, one.words) for one in found.each if "push" not in one.factors]
    assert words == [
        *(("EQU", "1.1 weight"), ("EQU", "0.9 weight"), ("STR", "1.2 weight")),
        *(("STR", "1 weight"), ("characteristic", "1 weight")),
    ]
    assert found.each[found.governs].words == "0.9 weight + 1.5 push"
    told = [x.split("; ") for x in found.tables()[1]["permanent"]]
    assert told == [["1.1 or 0.9"], ["1.35 or 1", "weight 1.2 or 1"], ["1"]]


def test_cases_are_those_of_the_file_of_the_model_too(tmp_path: Path) -> None:
    assembly = tower(2)
    wind = LoadCase(LoadCase.point_load(assembly, 1, (500.0, 0.0, 0.0)).wrench, "wind")
    model = Model(assembly, STACK.contacts, cases=(LoadCase.gravity(assembly), wind))
    case = '[case.wind]\nkind = "variable"\ncategory = "wind"'
    found = read_combinations(written(tmp_path, 'situations = ["STR"]', WEIGHT, case), model)
    assert found[1].load.wrench[1, 0] == pytest.approx(750.0)
    part = WEIGHT + 'blocks = "block-1"'
    some = read_combinations(written(tmp_path, 'situations = ["characteristic"]', part), model)
    assert some[0].load.wrench[:, 2].round().tolist() == [0.0, -23544.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WEIGHT + "factors = [0.9, 1.1]", "case.weight.factors: contradicts itself: 0.9"),
        (WEIGHT + "factors = [1.2, 1]", "different ones: EQU 1.1, 0.9; STR 1.35, 1; .* { STR = "),
        (OWN + WEIGHT + "factors = [1.2, 1]", "case.weight.factors: is for no situation"),
        (WEIGHT + "factors = { ULS = [1.2, 1] }", "unknown field 'ULS'; known are EQU"),
        (PUSH.format(1).replace("0.5,", "0.8,"), "case.push.psi: contradicts itself"),
        (PUSH.format(1) + 'category = "A"', "case.push: has psi and a category"),
        (PUSH.format(1) + 'group = "gr1a"', 'one case acts at a time; write together = "gr1a"'),
        ('[case.q]\nkind = "variable"\nload = "gravity"', "has neither psi nor a category"),
        (WEIGHT.replace("gravity", "block-1:500"), "case.weight.load: '500' is not a load"),
        (WEIGHT.replace("gravity", "train:lm1"), "case.weight.load: a train is no load of a case"),
        ('[case.snow]\nkind = "permanent"', "no load case is called 'snow'"),
        (WEIGHT.replace("permanent", "dead"), "case.weight.kind: is 'dead'"),
        (WEIGHT + "[material]\nfriction = 0.8", "material.friction: is 0.8"),
        (WEIGHT + '[material]\nstrength = "D9"', "there is no class 'D9'"),
        ('standard = "din"' + WEIGHT, "there is no standard 'din'"),
        ('situations = ["ULS"]' + WEIGHT, "there is no situation 'ULS'"),
        ('situations = ["seismic"]' + WEIGHT, "gives no combination"),
        (WEIGHT + "reversible = true", "case.weight.reversible: is of no permanent case"),
        (PUSH.format(1), "case: block 'block-1' has no permanent load, so no weight"),
        (WEIGHT + 'blocks = "block-0"', "block 'block-1' has no permanent load"),
        ("situations = []", "'case' is missing"),
        ("[case", "is not TOML"),
        ('situations = ["EQU"]' + WEIGHT + QUAKE, 'seismic, .*; add "seismic" to situations, or'),
        (OWN + WEIGHT + QUAKE, 'case.quake: is seismic, .* a [[situation]] with event = "seismic"'),
    ],
)
def test_what_contradicts_or_is_not_known_is_refused_in_one_line(
    text: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(DrystoneError, match=message.replace("[", r"\[")) as refused:
        read_combinations(written(tmp_path, text), STACK)
    assert "\n" not in str(refused.value)


def test_a_load_of_the_model_acts_where_a_case_says_so_and_is_refused_elsewhere(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It falls in a check; cases that say gravity have another load."""
    drystone.write(tower(2), tmp_path / "stack.json")
    weight = 'situations = ["characteristic"]' + WEIGHT
    asked = ["combine", str(tmp_path / "stack.json"), str(written(tmp_path, weight))]
    for loaded in (
        ["--gravity", "12,0,-9.81"],
        ["--load", "block-1:50000,0,0"],
    ):
        assert main([*asked, *loaded]) == 2
        assert 'write load = "model" in a case' in capsys.readouterr().err
    falls = [*asked, "--seismic", "1.2,0"]
    page = tmp_path / "report.html"
    assert main(["report", falls[1], "--cases", *falls[2:], "--out", str(page)]) == 2
    assert not page.exists()
    written(tmp_path, weight.replace("gravity", "model"))
    assert main(falls) == 1
    assert main(asked) == 0


ALL = '[case.all]\nkind = "{}"\nload = "model"\n'


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (WEIGHT + ALL.format("permanent"), "block-1' twice, in 'weight' and 'all'"),
        (WEIGHT + ALL.format("accidental"), "block-1' twice, in 'weight' and 'all'"),
        (ALL.format("permanent").replace('"model"', '["gravity", "model"]'), "twice, in 'all'"),
        (WEIGHT + ALL.format("permanent").replace("model", "dead"), "twice, in 'weight' and 'all'"),
        (WEIGHT + WEIGHT.replace("weight", "more") + 'blocks = "block-1"', "'weight' and 'more'"),
    ],
)
def test_the_weight_of_a_block_acts_once_in_a_combination(
    text: str, named: str, tmp_path: Path
) -> None:
    weight = LoadCase.gravity(STACK.assembly)
    push = LoadCase.point_load(STACK.assembly, 1, (500.0, 0.0, 0.0))
    dead = LoadCase(weight.wrench, "dead")
    load = weight + push if '"model"' in text else weight
    model = Model(STACK.assembly, STACK.contacts, load=load, cases=(dead,))
    with pytest.raises(DrystoneError, match=named) as refused:
        read_combinations(written(tmp_path, text), model)
    assert 'is written BLOCK:WHAT: load = "block-1:23544N"' in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_weight_of_some_blocks_acts_at_their_centroids(tmp_path: Path) -> None:
    """0.9 W holds until its centroid is over the edge, from 0.5 m behind and 1 m above it.

    Pushed by 0.1 g it is tan t = 0.4 / 1.05 in place of 0.5; its roof alone is shaken beside it.
    """
    blocks = [box((9.0, 9.0, 1.0), (-1, -1, -1), "base"), box((1, 1, 2), (0, 0, 0), "a")]
    made = drystone.Assembly([*blocks, box((1, 1, 2), (3, 0, 0), "b")]).with_fixed(["base"])
    cases = [WEIGHT.replace("weight", name) + f'blocks = "{name}"' for name in "ab"]
    cases[1] = cases[1].replace('"gravity"', '["gravity", "b:981N"]') + "\nshaken = true"
    path = written(tmp_path, 'situations = ["EQU", "seismic"]', *cases, QUAKE)
    each = {one.words: one.of(Model.of(made)) for one in read_combinations(path, Model.of(made))}
    for words, tangent in (("0.9 a + 1.1 b", 0.5), ("1 a + 1 b + 1 quake", 0.4 / 1.05)):
        moved = 0.5 + np.hypot(0.5, 1.0) * np.sin(np.arctan(tangent) - np.arctan(0.5))
        found = drystone.seismic.local_mechanism(each[words], part="a").oscillator
        assert found.displacement == pytest.approx(moved)
    assert each["1 a + 1 b + 1 quake"].load.wrench[2, 0] == pytest.approx(4708.8 + 98.1)


@pytest.mark.parametrize("share", [0.9, 1.0])
def test_a_roof_that_weighs_as_much_as_its_block_is_no_second_weight(
    share: float, tmp_path: Path
) -> None:
    column = tower(3)
    force = share * LoadCase.gravity(column).wrench[2, :3]
    roof = replace(LoadCase.point_load(column, "block-2", force), name="roof")
    models = STACK, Model(column, Model.of(column).contacts, cases=(roof,))
    words = f"block-1:{-force[2]}N", "roof"
    for model, word in zip(models, words, strict=True):
        case = f'[case.roof]\nkind = "permanent"\nload = "{word}"\n'
        found = read_combinations(written(tmp_path, WEIGHT, case), model)
        (one,) = (one for one in found if one.situation.name == "characteristic")
        assert one.load.wrench[-1, 2] == pytest.approx(-23544.0 * (1.0 + share))


def test_a_load_of_the_model_without_weight_and_parts_of_the_weight_are_no_second_weight(
    tmp_path: Path,
) -> None:
    """An earthquake upward and parts of other blocks act beside it."""
    push = LoadCase.point_load(STACK.assembly, 1, (500.0, 0.0, 0.0))
    lift = LoadCase(-0.3 * LoadCase.gravity(STACK.assembly).wrench, "lift")
    model = Model(STACK.assembly, STACK.contacts, load=push, cases=(lift,))
    quake = '[case.lift]\nkind = "seismic"\nreversible = true\n'
    parts = [WEIGHT + f'blocks = "block-{i}"' for i in (0, 1)]
    apart = parts[0].replace("weight", "below") + parts[1]
    found = read_combinations(written(tmp_path, apart, ALL.format("permanent"), quake), model)
    characteristic = [one for one in found if one.situation.name == "characteristic"]
    assert characteristic[0].load.wrench[1, [0, 2]].round().tolist() == [500.0, -23544.0]


def test_the_command_tells_the_combination_that_governs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drystone.write(tower(2), tmp_path / "stack.json")
    path = written(tmp_path, 'situations = ["EQU"]', WEIGHT, PUSH.format(14250))
    told = ["combine", str(tmp_path / "stack.json"), str(path), "--friction", "2"]
    assert main(told) == 1
    assert "governs: EQU: 0.9 weight + 1.5 push" in capsys.readouterr().out


def test_of_several_that_fall_the_one_that_carries_the_least_share_governs(tmp_path: Path) -> None:
    """By moments about the edge: g W b/2 = s 1.5 Q h/2, with g = 1.1 and 0.9."""
    path = written(tmp_path, 'situations = ["EQU"]', WEIGHT, PUSH.format(20000))
    found = combinations(tower(2), path, friction=2.0)
    carried = {g: g * 23544.0 / (1.5 * 20000.0) for g in (0.9, 1.1)}
    told = {one.words: x for one, x in zip(found.each, found.carries, strict=True)}
    for g, share in carried.items():
        assert told[f"{g} weight + 1.5 push"] == pytest.approx(share, abs=2e-3)
        assert np.isnan(told[f"{g} weight"])
    assert found.each[found.governs].words == "0.9 weight + 1.5 push"
    said = " ".join(one.text for one in found.sentences())
    assert found.title.startswith("Does not stand in 2")
    assert "governs: EQU: 0.9 weight + 1.5 push" in said
    assert "beside the permanent ones it stands up to 0.706 of its other actions" in said
    column = found.tables()[0]["carries_of_others"]
    assert column[:2] == pytest.approx([carried[0.9], carried[1.1]], abs=2e-3)


def test_what_falls_under_its_permanent_actions_alone_carries_none(tmp_path: Path) -> None:
    """It governs over what carries a share of the others: 1.1 of a lasting push is too much."""
    lasting = '[case.pull]\nkind = "permanent"\nload = "block-1:24000,0,0N"\nfactors = [1.1, 0.5]'
    path = written(tmp_path, 'situations = ["EQU"]', WEIGHT, lasting, PUSH.format(20000))
    found = combinations(tower(2), path, friction=2.0)
    governing = found.each[found.governs]
    assert governing.factors["pull"] == 1.1
    assert found.carries[found.governs] == 0.0
    said = " ".join(one.text for one in found.sentences())
    assert "it does not stand under its permanent actions alone" in said


def test_the_loads_of_the_cases_add_up_to_those_of_the_combination_that_governs(
    tmp_path: Path,
) -> None:
    """By factors, accelerations and the forces of each block, as the sheet tells them."""
    cases = """
situations = ["STR"]
[case.low]
kind = "permanent"
load = "gravity"
blocks = "voussoir-0*"
[case.high]
kind = "permanent"
load = "gravity"
blocks = "voussoir-1*"
[case.fill]
kind = "permanent"
load = "fill:cover=0.3m,weight=20kN/m3,k=0.3"
factors = [1.2, 0.9]
[case.cart]
kind = "variable"
category = "G"
load = ["voussoir-05:20kN", "voussoir-06:3kN,0,0"]
"""
    file = written(tmp_path, cases)
    found = combinations(segmental_bridge(5.0, 1.5, voussoirs=20), file, needed_of="none")
    told = {one.title: one for one in found.tables()}
    assert told["situations"]["permanent"].tolist() == ["1.35 or 1; fill 1.2 or 0.9"]
    assert told["situations"]["leading"].tolist() == ["1.5"]
    assert told["cases"]["psi"].tolist() == ["", "", "", "0.7, 0.5, 0.3"]
    assert told["cases"]["factors"].tolist()[1:3] == ["of the situation", "STR 1.2, 0.9"]
    assembly, factors = found.model.assembly, found.each[found.governs].factors
    total = np.zeros((len(assembly), 3))
    for case, along in zip(told["cases"]["case"], told["cases"]["acceleration"], strict=True):
        total += factors.get(case, 0.0) * assembly.mass[:, None] * along
    for row in told["loads of cases"]:
        total[assembly.indices([row["block"]])] += factors.get(row["case"], 0.0) * np.array(
            row["force"]
        )
    free = assembly.free
    assert total[free] == pytest.approx(found.governing.load.wrench[free, :3], abs=1e-6)
    assert found.to_dict()["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    assert found.asked.facts()["Options"] == "cases cases.toml"
    page = tmp_path / "sheet.html"
    write_report(found, page)
    sheet = page.read_text(encoding="utf-8")
    assert all(one in sheet for one in ("cases.toml", found.sha256, "loads of cases"))
    assert "passive none (a load spreads 0.5 by depth, evenly)" in sheet


@pytest.mark.parametrize(("live", "stands"), [("127kN", True), ("129.1kN", False)])
def test_fill_that_weighs_less_resists_less(tmp_path: Path, live: str, stands: bool) -> None:
    """190.9 kN by a linear program apart with 0.9 of weight and resistance; 196 with all of it."""
    weight = '[case.weight]\nkind = "permanent"\nload = "model"\n'
    pushed = f'[case.live]\nkind = "variable"\nload = "voussoir-08:{live}"\npsi = [0.7, 0.5, 0.3]\n'
    file = written(tmp_path, 'situations = ["EQU"]', weight, pushed)
    fill = "fill:cover=0.4m,weight=20kN/m3,k=0.3,passive=1.5"
    bridge = segmental_bridge(5.0, 1.5)
    found = combinations(bridge, file, friction=0.6, load=fill, tie=["fill"], needed_of="none")
    told = {one.words: x.stable for one, x in zip(found.each, found.results, strict=True)}
    assert told["0.9 weight + 1.5 live"] is stands


def test_fill_of_a_case_resists_where_it_is_the_load_of_the_model_too(tmp_path: Path) -> None:
    """As with the load of the model in a case; fill of another weight is refused."""
    fill = "fill:cover=0.4m,weight=20kN/m3,k=0.3,passive=1.5"
    live = '[case.live]\nkind = "variable"\nload = "voussoir-08:120kN"\npsi = [0.7, 0.5, 0.3]\n'
    apart = WEIGHT + f'[case.fill]\nkind = "permanent"\nload = "{fill}"\n'
    bridge = segmental_bridge(5.0, 1.5)
    one = as_model(bridge, friction=0.6, load=fill, tie=["fill"])
    found = {}
    for name, text in (("both", WEIGHT.replace("gravity", "model")), ("apart", apart)):
        each = read_combinations(written(tmp_path, 'situations = ["EQU"]', text, live), one)
        found[name] = next(x for x in each if set(x.factors.values()) == {0.9, 1.5}).of(one)
    assert found["apart"].load.wrench == pytest.approx(found["both"].load.wrench, abs=1e-6)
    assert drystone.check(found["apart"]).stable
    pulls = [x.contacts.tie_strength for x in found.values()]
    assert pulls[0] == pytest.approx(pulls[1])
    with pytest.raises(DrystoneError, match="no case has the load of the model"):
        read_combinations(written(tmp_path, apart.replace("20kN", "18kN")), one)
    with pytest.raises(DrystoneError, match="a file of combinations can have the same as a case"):
        as_model(bridge, tie=["fill"])
