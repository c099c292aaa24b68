"""Calculation reports: what stands in them, and that their hand checks hold."""

import html
import re
from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, LoadCase, Model, Verdict, report
from drystone.answer import Answer
from drystone.base.table import Table
from drystone.cli import main
from drystone.limits import Limit, LimitOptions, limit_friction, limit_load, limit_train
from drystone.loads import Earth, Fill, Train
from drystone.models import arch, box, segmental_bridge, tower, vault, wall
from drystone.models.simple import prism
from drystone.report import TitleBlock, assess, write_report
from drystone.report.document import Document, Picture, Section
from drystone.report.hand_checks import (
    as_one_block,
    balance,
    crown_thrusts,
    fall_words,
    least_strength,
    mechanism_table,
    weights,
)
from drystone.report.report_pdf import pdf_of
from drystone.report.report_sections import document_of
from drystone.report.sketches import dimensions_picture, loads_picture
from drystone.report.write_report import html_of
from drystone.sequence import plan
from drystone.view.figure import draw


@pytest.fixture(scope="module")
def bridge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "bridge.json"
    drystone.write(arch(0.2, 7), path)
    return path


@pytest.fixture(scope="module")
def answers(bridge: Path) -> list[Answer]:
    model = drystone.read(bridge, friction=0.7, load="voussoir-02:0.3kN")
    model = replace(model, notes=("it is 440 m across: is the unit right (--units cm)?",))
    return assess(model, limits=["load seismic:1,0"], sensitivity=False)


@pytest.fixture(scope="module")
def document(answers: list[Answer]) -> Document:
    about = TitleBlock(project="<Old> bridge", author="N. N.", date="2026-01-02")
    return document_of(answers, about)


def test_a_report_has_input_loads_method_verdict_proof_and_hand_checks(
    document: Document, answers: list[Answer]
) -> None:
    page = html_of(document)
    text = re.sub(r"<[^>]+>", " ", page)
    asked = answers[0].asked
    for expected in (
        "&lt;Old&gt; bridge", "N. N.", asked.sha256, asked.version, "bridge.json", "voussoir-02",
        "0, 0, -300 N", "friction 0.7", "2400", "Stands up to load factor 0.", "reactions",
        "seismic 1, 0 g", "it is 440 m across", "Checked by", "signature",
        "Proof, computed again", "thrust at the crown", "positive in compression", "kern",
    ):  # fmt: skip
        assert expected in text or expected in page, expected
    assert page.count(" m wide, right: ") == 2 * 8  # below each plan, and instead of it
    assert page.count('src="data:image/png') == 8
    assert "unit right" not in page  # a question is asked before anything is signed
    assert not re.search(r"https?://", page)


def test_a_wall_is_checked_by_hand_for_sliding_and_overturning_as_one_block() -> None:
    """Cubes of 1 m on one that is fixed: W = 2 x 23,544 N, and 9 kN/m2 x 2^2 / 2 of earth."""
    load = LoadCase.gravity(tower(3)) + Earth("-x", 18e3, 0.5).on(tower(3))
    table = as_one_block(drystone.check(Model.of(tower(3), friction=0.6, load=load)))
    assert table is not None
    told = dict(zip(table["quantity"].tolist(), table["value"].tolist(), strict=True))
    assert told["vertical load, V"] == "47.1 kN"
    assert told["sliding, f V / H"] == f"{0.6 * 47088.0 / 18e3:.4g}"
    assert told["overturning, Mv / Mh"] == f"{47088.0 * 0.5 / (18e3 * 2.0 / 3.0):.4g}"
    arm = 0.5 - 12e3 / 47088.0
    assert told["from that edge to the resultant, (Mv - Mh) / V"] == f"{1e3 * arm:.3g} mm"
    assert as_one_block(drystone.check(Model.of(tower(3), friction=0.6))) is None


def test_a_load_on_the_edge_of_a_wall_holds_it_by_its_own_arm() -> None:
    """20 kN down at 0.1 m from the toe and 3 kN along x at 1.5 m above it, W = 2 x 23,544 N."""
    wall = tower(3)
    load = LoadCase.point_load(wall, "block-2", (3e3, 0, 0), at=(0.5, 0.5, 2.5))
    load += LoadCase.point_load(wall, "block-1", (0, 0, -20e3), at=(0.9, 0.5, 2))
    load += LoadCase.gravity(wall)
    table = as_one_block(drystone.check(Model.of(wall, friction=0.6, load=load)))
    assert table is not None
    told = dict(zip(table["quantity"].tolist(), table["value"].tolist(), strict=True))
    holds, turns = 47088.0 * 0.5 + 20e3 * 0.1, 3e3 * 1.5
    assert told["overturning, Mv / Mh"] == f"{holds / turns:.4g}"


@pytest.mark.parametrize(("place", "nearest"), [(0.55, 415), (1.0, 238), (0.1, 509)])
def test_loads_on_one_block_keep_their_own_arms_and_rows(place: float, nearest: float) -> None:
    """1 x 1.1 x 2.4 m, 62.16 kN, 40 kN on it, 18 kN/m3 x 2.4^2 / 6 = 17.28 kN of earth at 0.8 m."""
    slab, one = box((3.0, 3.0, 0.3), (-1.0, -1.0, -0.3), "slab"), box((1.0, 1.1, 2.4), name="w")
    wall = Model.of(Assembly((slab, one)).with_fixed([0]), friction=0.6)
    words = ["earth:side=-y,weight=18kN/m3,k=active:30deg", f"w:0,0,-40000@0.5,{place},2.4"]
    found = drystone.check(wall, load=[*words, "w:1g", "w:2g", "w:3g"])
    table = as_one_block(found)
    assert table is not None
    holds, turns = 62.156e3 * 0.55 + 40e3 * (1.1 - place), 17.28e3 * 0.8
    told = [text for name, text in zip(*table.columns.values(), strict=True) if "Mv / Mh" in name]
    assert told == [f"{holds / turns:.4g}"]
    assert table["value"][-2] == f"{nearest} mm"
    masses = [f"mass of 0.00{i} kg" for i in (1, 2, 3)]
    assert found.loads()["load"].tolist()[1:] == [
        f"0, 0, -40000 N on 'w' at 0.5, {place:g}, 2.4 m",
        *masses,
    ]


def test_a_wall_that_is_shaken_askew_turns_about_its_long_edge() -> None:
    """4 x 1 x 3 m, 0.33 of its weight along both: 0.5 / (0.33 x 1.5) about the edge along x."""
    wall = Assembly((box((4.0, 1.0, 0.5), name="foot"), box((4.0, 1.0, 3.0), (0.0, 0.0, 0.5))))
    wall = wall.with_fixed([0])
    load = LoadCase.gravity(wall) + LoadCase.seismic(wall, 0.33, 0.33)
    table = as_one_block(drystone.check(Model.of(wall, friction=0.7, load=load)))
    assert table is not None
    told = dict(zip(table["quantity"].tolist(), table["value"].tolist(), strict=True))
    assert told["overturning, Mv / Mh"] == f"{0.5 / (0.33 * 1.5):.4g}"


def test_what_stands_on_an_edge_has_no_foot_to_turn_about() -> None:
    wedge = prism([(0.5, 0.5), (0.0, 1.5), (1.0, 1.5)], (0.0, 1.0), "wedge")
    blocks = Assembly((box((1.0, 1.0, 0.5), name="foot"), wedge)).with_fixed([0])
    load = LoadCase.gravity(blocks) + LoadCase.seismic(blocks, 0.1)
    assert as_one_block(drystone.check(Model.of(blocks, friction=0.7, load=load))) is None


def test_the_ground_below_a_model_has_no_weight_in_a_report(tmp_path: Path) -> None:
    drystone.write(tower(2), tmp_path / "tower.obj")
    model = drystone.read(tmp_path / "tower.obj", supports="ground", density=2200.0, friction=0.6)
    table = weights(model)
    assert table["of"].tolist() == ["free blocks"]
    assert table["volume"].tolist() == pytest.approx([2.0])
    assert model.origin.reading["density"] == "2200"
    answer = limit_load(model, "seismic:1,0", options=LimitOptions(equilibrium_only=True))
    assert answer.asked.facts()["Load"] == "gravity, and seismic 1, 0 g times a factor"


@pytest.mark.usefixtures("unpainted")
def test_the_summary_names_the_load_and_the_factor_that_stand(answers: list[Answer]) -> None:
    limit = answers[1]
    assert isinstance(limit, Limit)
    said = document_of(answers, TitleBlock()).sections[0].parts
    (told,) = [one for one in said if isinstance(one, str) and "load factor" in one]
    assert limit.best.standing is not None
    assert limit.best.falling is not None
    assert (
        "Load: gravity + 0, 0, -300 N on 'voussoir-02', and seismic 1, 0 g times a factor." in told
    )
    assert limit.best.falling.load.name not in told


def test_the_same_answers_give_the_same_bytes_and_text_that_can_be_searched(
    document: Document, answers: list[Answer]
) -> None:
    pytest.importorskip("reportlab")
    one = pdf_of(document)
    assert one.startswith(b"%PDF")
    assert b"/ToUnicode" in one
    assert one == pdf_of(document)
    pictures = [part for section in document.sections for part in section.parts]
    again = dimensions_picture(answers[0].model)
    assert again.caption.startswith("Overall dimensions of the free blocks")
    assert again.png in [one.png for one in pictures if isinstance(one, Picture)]


def test_the_same_commands_give_the_same_bytes_but_for_the_date(
    bridge: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A PDF and a page of two runs, each against the document of the other run."""
    pytest.importorskip("reportlab")
    kept: list[Document] = []

    def documented(*given: Any) -> Document:
        kept.append(document_of(*given))
        return kept[-1]

    monkeypatch.setattr(import_module(write_report.__module__), "document_of", documented)
    asked = ["--friction", "0.7", "--limit", "load voussoir-02:1kN", "--date"]
    made = [tmp_path / name for name in ("0.pdf", "1.html")]
    for date, path in zip(("2026-01-02", "2026-01-03"), made, strict=True):
        assert main(["report", str(bridge), *asked, date, "--out", str(path)]) == 0
    one, other = kept
    again = replace(other, entries={**other.entries, "Date": "2026-01-02"})
    assert made[0].read_bytes() == pdf_of(again)
    told = html_of(one).replace("2026-01-02", "2026-01-03")
    assert told == made[1].read_text(encoding="utf-8")


@pytest.mark.usefixtures("unpainted")
def test_the_first_page_has_the_margin_the_earth_and_the_law_of_mortar() -> None:
    earth = "earth:side=-x,weight=18kN/m3,k=0.33,surcharge=5kPa"
    capacity = "tension=0.05MPa"
    answers = assess(tower(2), sensitivity=False, friction=0.6, load=earth, joint_capacity=capacity)
    document = document_of(answers, TitleBlock())
    page = repr([section.parts for section in document.sections[:2]])
    for told in ("surcharge 5 kPa", "brittle"):
        assert told in page
    dry = document_of(assess(tower(2), sensitivity=False, friction=0.6), TitleBlock())
    assert any("Safety: forces balance a tilt" in str(one) for one in dry.sections[0].parts)
    assert "." not in dry.sections[0].parts


def test_what_acts_on_all_free_blocks_is_in_balance() -> None:
    assembly = arch(0.2, 7)
    load = LoadCase.gravity(assembly) + LoadCase.moment(assembly, "voussoir-02", (0.0, 20.0, 0.0))
    result = drystone.check(Model.of(assembly, friction=0.7, load=load))
    made = balance(result)
    assert np.abs(made["force"][-1]).max() < 1e-6 * np.abs(made["force"]).max()
    assert np.abs(made["moment"][-1]).max() < 1e-6 * np.abs(made["moment"]).max()
    free, supports = weights(result.model)["weight"]
    assert free == pytest.approx(9.81 * assembly.mass[assembly.free].sum())
    assert supports == pytest.approx(9.81 * assembly.mass[assembly.fixed].sum())


def test_the_thrust_at_the_crown_by_hand_is_that_of_the_joints_and_of_the_reactions() -> None:
    result = drystone.check(arch(0.2, 7), friction=0.7)
    (thrust,) = crown_thrusts(result)
    assert thrust.by_hand == pytest.approx(thrust.by_joints, rel=1e-6)
    assert thrust.by_hand == pytest.approx(abs(result.reactions()["force"][0, 0]), rel=1e-6)
    (across,) = crown_thrusts(drystone.check(vault(courses=7, blocks=2), friction=0.7))
    assert across.by_hand == pytest.approx(across.by_joints, rel=1e-6)


def test_fill_acts_in_its_columns_and_other_moments_of_a_thrust_are_told_apart() -> None:
    """Half a ring and its columns have their middle 1.475 m from the springing, by hand."""
    bridge = segmental_bridge(8.0, 2.0, 0.5, 24)
    fill = "fill:cover=0.4m,weight=19kN/m3,k="
    (still,) = crown_thrusts(drystone.check(bridge, density=2200.0, load=f"{fill}0"))
    assert still.arm == pytest.approx(1.475, abs=6e-4)
    assert max(map(abs, still.moments.values())) < 1e-6 * still.load * still.arm
    assert still.by_hand == pytest.approx(still.by_joints, rel=1e-6)
    given = f"{fill}0.3"
    moved = drystone.check(bridge, density=2200.0, load=given, seismic=(0.05, 0.0))
    (shaken,) = crown_thrusts(moved)
    assert len([one for one in shaken.moments.values() if abs(one) > 1e2]) == 3
    assert shaken.by_hand == pytest.approx(shaken.by_joints, rel=1e-6)
    told = shaken.table()["quantity"].tolist()
    assert "moment of masses pushed sideways" in told
    assert "moment of pressure and other loads" in told
    assert as_one_block(moved) is None  # it stands on two springers
    free, _, carried = weights(moved.model)
    assert (carried["of"], carried["blocks"]) == ("fill", 24)
    assert free["weight"] + carried["weight"] == pytest.approx(2.0 * still.load, rel=1e-9)


def test_each_span_has_its_thrust_and_a_wall_has_none() -> None:
    result = drystone.check(segmental_bridge(voussoirs=8, spans=2), friction=0.7)
    both = crown_thrusts(result)
    ends = np.abs(result.reactions()["force"][[0, -1], 0])
    assert [one.by_hand for one in both] == pytest.approx(ends, rel=1e-6)
    assert both[0].joint.startswith("'span-1-")
    assert crown_thrusts(drystone.check(tower(3))) == []
    pushed = drystone.check(wall(4, 3), friction=0.7, seismic=(0.3, 0.0))
    assert crown_thrusts(pushed) == []


@pytest.mark.parametrize(
    ("spans", "height", "backing"),
    [(1, 0.0, 0.0), (1, 3.0, 0.0), (1, 3.0, 0.6), (2, 0.0, 0.0), (2, 3.0, 0.0)],
)
def test_the_crown_is_that_of_the_ring_whatever_it_stands_on(
    spans: int, height: float, backing: float
) -> None:
    """Ten of twenty voussoirs of R = 5 m, t = 0.5 m over 2 asin(0.8) weigh 57.23 kN by hand."""
    bridge = segmental_bridge(8.0, 2.0, 0.5, 20, spans=spans, height=height, backing=backing)
    result = drystone.check(bridge, friction=0.7)
    found = crown_thrusts(result)
    voussoir = 0.5 * np.sin(2.0 * np.arcsin(0.8) / 20.0) * (5.5**2 - 5.0**2)
    starts = [f"span-{i + 1}-" for i in range(spans)] if spans > 1 else [""]
    assert [one.joint for one in found] == [
        f"'{x}voussoir-09' and '{x}voussoir-10'" for x in starts
    ]
    pushes = abs(result.reactions()["force"][0, 0])
    for one in found:
        assert one.load == pytest.approx(10.0 * voussoir * 2400.0 * 9.81, rel=1e-9)
        assert 2.0 < one.rise < 2.5
        assert one.by_hand == pytest.approx(one.by_joints, rel=1e-6)
        assert one.by_joints == pytest.approx(pushes, rel=1e-6)


@pytest.mark.usefixtures("unpainted")
def test_a_report_says_that_no_arch_was_recognised() -> None:
    told = html_of(document_of([drystone.check(tower(3))], TitleBlock()))
    assert "No thrust at a crown: no arch was recognised" in told


def test_a_report_on_what_falls_has_the_mechanism_and_why(tmp_path: Path) -> None:
    answers = assess(tower(2), friction=0.3, seismic=(0.4, 0.0))
    assert answers[0].title.startswith("Falls")
    write_report(answers, tmp_path / "falls.html")
    text = (tmp_path / "falls.html").read_text(encoding="utf-8")
    assert "UNSTABLE" in text
    assert "motion of what falls" in text
    assert html.escape(answers[1].sentences()[1].text[1:]) in text


@pytest.mark.usefixtures("unpainted")
def test_the_falling_side_of_a_limit_has_its_mechanism_with_the_work_of_the_loads() -> None:
    """A cube of 1 m turns about its lower edge: its weight and the push beyond it do work on it."""
    answers = assess(tower(2), friction=1.5, limits=["load block-1:1kN,0,0"])
    limit = answers[1]
    assert isinstance(limit, Limit)
    falling = limit.best.falling
    assert falling is not None
    table = mechanism_table(falling)
    assert table is not None
    assert table["block"].tolist() == ["block-1"]
    moves, turns = table["moves"][0], np.radians(table["turns"][0])
    assert moves == pytest.approx(np.cross(turns, [-0.5, 0.0, 0.5]), abs=1e-6)
    push, weight = 1e3 * limit.best.falls, 2400.0 * 9.81
    work = push * moves[0] - weight * moves[2]
    assert float(table["work_of_loads"][0]) == pytest.approx(work, rel=2e-3)
    assert "mechanism of 1 block: the loads do work of" in fall_words(falling)
    assert "rest is 100 % of the sum of the absolute works of blocks" in fall_words(falling)
    page = html_of(document_of(answers, TitleBlock()))
    assert "unstable, no contact forces can balance the loads; mechanism of 1 block" in page
    assert limit.best.standing is not None
    where = f"'{limit.title}', at the limit of collapse and not in service"
    told = f"In the state of {where}, under {limit.best.standing.load.name}."
    assert told in html.unescape(page)


def test_works_have_the_digits_that_show_a_tiny_excess() -> None:
    """Their printed sum, less what joints take up, is the printed rest to a tenth and more."""
    options = LimitOptions(equilibrium_only=True, width=1e-7)
    limit = drystone.limit_load(arch(0.2, 7), "voussoir-02:1kN", friction=0.7, options=options)
    falling = limit.best.falling
    assert falling is not None
    table = mechanism_table(falling)
    assert table is not None
    works = np.array([float(one) for one in table["work_of_loads"]])
    told = re.search(
        r"work of (\S+) N m, all joints take up at most (\S+) N m", fall_words(falling)
    )
    share = re.search(r"rest is (\S+) % of the sum", fall_words(falling))
    assert told is not None
    assert share is not None
    rest = 0.01 * float(share[1]) * np.abs(works).sum()
    assert 0.0 < rest < 1e-4 * np.abs(works).max()
    assert works.sum() - float(told[2]) == pytest.approx(rest, rel=0.1)
    assert float(told[1]) - float(told[2]) == pytest.approx(rest, rel=0.1)


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ("tillt", "there is no limit 'tillt'"),
        ("load", "live is missing"),
        ("tilt --axes y", "there is no argument 'axes'"),
        ("tilt --axis", "needs a value"),
        ("tilt x y", "one word too many"),
    ],
)
def test_limits_that_do_not_exist_are_refused(limit: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        assess(tower(2), limits=[limit])


def test_the_title_block_is_read_from_toml_and_options_come_first(tmp_path: Path) -> None:
    path = tmp_path / "about.toml"
    path.write_text('project = "A wall"\nauthor = "N. N."\n')
    block = TitleBlock(author="M. M.").over(TitleBlock.read(path))
    assert block.entries("today") == {"Project": "A wall", "Author": "M. M.", "Date": "today"}
    for text, message in (
        ("projekt = 'A'", "unknown field 'projekt'"),
        ("project = 1", "must be a string"),
        ("project = ", "is not TOML"),
    ):
        path.write_text(text)
        with pytest.raises(drystone.FormatError, match=message):
            TitleBlock.read(path)


def test_texts_that_no_page_can_hold_are_cut_or_written_escaped(tmp_path: Path) -> None:
    long, half = "n" * 10_000, "half a letter \ud800"
    about = TitleBlock(project=half, author=long, number="<b>&lt;</i> {0}")
    model = Model.of(tower(2))
    write_report(drystone.solve_rbe(model), tmp_path / "hostile.pdf", about=about)
    assert (tmp_path / "hostile.pdf").read_bytes().startswith(b"%PDF")


def test_other_suffixes_are_refused(bridge: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(bridge), "--out", str(bridge.with_suffix(".doc"))]) == 2
    assert "does not end in .pdf or .html" in capsys.readouterr().err
    with pytest.raises(drystone.FormatError, match="PDF or HTML"):
        report.write_report(drystone.check(tower(2)), bridge.with_suffix(".doc"))


def test_a_heading_stays_with_the_picture_below_it(
    document: Document, monkeypatch: pytest.MonkeyPatch
) -> None:
    platypus = pytest.importorskip("reportlab.platypus")
    picture = next(
        one for section in document.sections for one in section.parts if isinstance(one, Picture)
    )
    drawn: list[tuple[str, int]] = []
    for kind in (platypus.Image, platypus.Paragraph):

        def draw(self: Any, before: Any = kind.draw) -> None:
            shown = isinstance(self, platypus.Image)
            text = "a picture" if shown else " ".join(self.getPlainText().split())
            drawn.append((text, self.canv.getPageNumber()))
            before(self)

        monkeypatch.setattr(kind, "draw", draw)
    for lines in range(38, 44):
        filled = Section("Before", ("line",) * lines)
        entries = {"Author": "N. N."}
        pdf_of(Document("A wall", entries, "foot", (filled, Section("Signs", (picture,)))))
    pages = [[page for text, page in drawn if text == one] for one in ("Signs", "a picture")]
    assert pages[0] == pages[1]
    assert len(pages[0]) == 6


def test_a_picture_becomes_smaller_where_it_then_fits_on_the_page(
    document: Document, monkeypatch: pytest.MonkeyPatch
) -> None:
    platypus = pytest.importorskip("reportlab.platypus")
    picture = next(
        one for section in document.sections for one in section.parts if isinstance(one, Picture)
    )
    drawn: list[tuple[int, float]] = []
    monkeypatch.setattr(
        platypus.Image,
        "draw",
        lambda self: drawn.append((self.canv.getPageNumber(), self.drawHeight)),
    )
    for lines in (20, 28, 40):
        filled = Section("Before", (*("line",) * lines, picture))
        pdf_of(Document("A wall", {"Author": "N. N."}, "foot", (filled,)))
    (_, full), (_, less), (_, again) = drawn
    assert [page for page, _ in drawn] == [1, 1, 2]
    assert 0.9 * full <= less < full  # letters of 8 points stay above 7
    assert again == full


def test_a_plan_can_be_reported(tmp_path: Path) -> None:
    write_report(plan(Model.of(tower(2), friction=0.6)), tmp_path / "plan.html")
    assert "Loads" in (tmp_path / "plan.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("unpainted")
def test_long_tables_stand_whole_in_an_annex_and_its_first_rows_in_the_text() -> None:
    result = drystone.check(Model.of(vault(courses=9, blocks=6), friction=0.8))
    made = document_of([result], TitleBlock()).sections
    listed = [one for section in made for one in section.parts if isinstance(one, Table)]
    blocks = [one for one in listed if one.title == "blocks"]
    count = len(result.assembly)
    assert [len(one) for one in blocks] == [40, count]
    assert made[-1].title.startswith("Annex 1")
    page = html_of(Document("A vault", {}, "foot", made))
    assert f"The first 40 of {count}; all in Annex 1." in page


@pytest.mark.usefixtures("unpainted")
def test_a_report_of_a_train_draws_the_worst_place_and_lists_axles_fill_and_both_sides() -> None:
    model = Model.of(segmental_bridge(voussoirs=10), friction=0.6)
    fill = Fill(cover=0.3, weight=2e4)
    found = limit_train(model, train=Train.named("lm1"), fill=fill, steps=3)
    made = document_of([found], TitleBlock())
    axles = found.axles()
    assert axles["load"].tolist() == [300e3, 300e3]
    assert np.diff(axles["x"]).round(9).tolist() == [1.2]
    drawn = {one.key: one for one in found.layers().stages[0].layers}
    assert {"axles", "road"} <= set(drawn)
    assert (drawn["line"].unit, drawn["line"].largest) == ("N/m", pytest.approx(27e3))
    page = html_of(made)
    for expected in (
        "multiplies all axles, 600 kN in all", "a load spreads 0.5 by depth", "passive none",
        f"at {len(found.places)} places ({len(found.places) - 3} of them "
        "where mechanisms of others end it sooner)",
        "axles at the worst place", "infinitely strong", "reactions", "thrust at the crown",
        *[f"{one.label[1:]}" for one in found.limit.layers().stages],
            ):  # fmt: skip
        assert expected in page, expected
    rest = replace(found.limit.rest, stands=0.9)
    under = replace(found, limit=replace(found.limit, rest=rest))
    both = document_of([drystone.solve_rbe(model), under], TitleBlock())
    first = both.sections[0].parts[0]
    assert str(first).startswith(under.title)  # though the bridge alone is balanced
    assert "Only the train has fill: give that with --load" in html_of(both)
    for one in (made, both):
        (hand,) = [each for each in one.sections if each.title.endswith("hand checks")]
        assert found.by_hand().title in [getattr(part, "title", "") for part in hand.parts]
    other = limit_friction(model, options=LimitOptions(equilibrium_only=True))
    beside = document_of([found, other], TitleBlock())
    assert any(one.title.endswith(f"{other.title}, without the train") for one in beside.sections)
    assert "at the limit of collapse and not in service, under" in html_of(beside)
    axes = draw(found.layers(), (5.0, 3.0), stage=0).axes[0]
    axes.apply_aspect()
    assert axes.get_position().y0 > 0.2  # room for three rows of the legend
    bar = next(line for line in axes.lines if line.get_linewidth() == 2.0)
    told = next(one.get_text() for one in axes.texts if one.get_text().endswith(" m"))
    long = np.ptp(axes.get_xlim()) * np.ptp(bar.get_xdata())
    assert long == pytest.approx(float(told.removesuffix(" m")), rel=0.02)


@pytest.mark.usefixtures("unpainted")
def test_the_first_sentence_of_a_report_is_the_worst_of_what_it_holds() -> None:
    alone = drystone.check(tower(2), friction=0.6)  # stands
    push = LoadCase.point_load(alone.assembly, "block-1", (1e6, 0.0, 0.0))
    under = limit_load(alone.model, push, options=LimitOptions(equilibrium_only=True))
    bad = replace(alone, verdict=Verdict.UNSTABLE)
    unsure = replace(alone, verdict=Verdict.UNDECIDED)
    for worst, others in ((under, [alone]), (bad, [unsure, under])):
        first = document_of([*others, worst], TitleBlock()).sections[0].parts[0]
        assert str(first).startswith(worst.sentences()[0].text), first


def test_loads_that_are_seen_end_on_are_drawn_aslant(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def drawn(*given: Any, **named: Any) -> Any:
        seen.append(named["toward"])
        return draw(*given, **named)

    monkeypatch.setattr("drystone.report.sketches.draw", drawn)
    wall = Assembly(
        [box((2.0, 0.2, 0.2)), box((2.0, 0.2, 0.2), (0.0, 0.0, 0.2), "top")]
    ).with_fixed(0)
    for push in ((9.0, 0.0, 0.0), (0.0, 9.0, 0.0)):
        load = LoadCase.gravity(wall) + LoadCase.point_load(wall, 1, push)
        loads_picture(Model.of(wall, friction=0.6, load=load))
    assert seen[0] is None
    assert abs(seen[1] @ [0.0, 1.0, 0.0]) < 0.9


def test_the_strength_that_forces_need_is_that_of_their_stress_block() -> None:
    needed, _ = least_strength(drystone.check(tower(2), friction=0.6))
    assert needed == pytest.approx(2400.0 * 9.81)
    load = LoadCase.gravity(tower(2)) + LoadCase.point_load(
        tower(2), "block-1", (0.0, 0.0, -2400.0 * 9.81), at=(0.25, 0.5, 2.0)
    )
    needed, at = least_strength(drystone.check(Model.of(tower(2), friction=0.6, load=load)))
    assert at == 0
    assert needed == pytest.approx(2.0 * 2400.0 * 9.81 / 0.75)  # 1 - 2 x 0.125 of the face


@pytest.mark.usefixtures("unpainted")
def test_a_tie_is_no_joint_of_stone() -> None:
    """A rod holds what friction does not: 0.05 of the weight."""
    blocks = [*tower(2).blocks, box((0.2, 0.2, 0.2), (-3.0, 0.4, 1.4), "anchor")]
    asked = {"friction": 0.6, "seismic": (0.65, 0.0), "tie": "block-1:anchor"}
    found = drystone.check(Assembly(blocks).with_fixed([0, 2]), **asked)
    table = found.joints()
    assert table["normal"][1] == pytest.approx(0.05 * 2400.0 * 9.81)
    assert table["peak_pressure"][1] == table["edge_ratio"][1] == 0.0
    assert least_strength(found)[1] == 0
    parts = [part for one in document_of([found], TitleBlock()).sections for part in one.parts]
    tables = {part.title: part for part in parts if isinstance(part, Table)}
    assert tables["joints by friction"]["friction"].tolist() == [0.6]
    assert list(tables["joints nearest to sliding or to a hinge"]["joint"]) == [0]
    assert list(tables["ties"]["block_a"]) == ["block-1"]


def test_forces_of_rounding_in_a_head_joint_need_no_strength() -> None:
    found = drystone.check(wall(), friction=0.6)
    assert least_strength(found)[0] == pytest.approx(found.joints()["peak_pressure"].max())


def test_the_strength_that_mortar_which_pulls_needs_is_that_of_a_linear_pressure() -> None:
    """A push of 1.2 W at half the height moves the force by 0.6 m: W/A (1 + 6 e/h)."""
    push = f"block-1:{1.2 * 2400.0 * 9.81},0,0"
    mortar = "tension=1MPa,cohesion=1MPa"
    found = drystone.check(tower(2), friction=0.6, joint_capacity=mortar, load=push)
    assert found.message == "stands on its mortar, uncracked"
    assert least_strength(found)[0] == pytest.approx(2400.0 * 9.81 * 4.6)


def test_reports_of_other_commands_have_a_title_block_too(bridge: Path, tmp_path: Path) -> None:
    about, out = tmp_path / "about.toml", tmp_path / "sheet.html"
    about.write_text('author = "A. Mason"\n')
    asked = ["inspect", str(bridge), "--title-block", str(about)]
    assert main(asked) == 2
    assert main([*asked, "--report", str(out)]) == 0
    assert "A. Mason" in out.read_text()


def test_what_falls_within_the_strength_of_its_joints_has_a_report() -> None:
    bridge = segmental_bridge(5.0, 1.5)
    found = assess(
        bridge, sensitivity=False, joint_capacity="compression=5MPa", load="voussoir-08:300kN"
    )
    assert [type(one) for one in found] == [drystone.Result, drystone.design.Diagnosis]


def test_what_stands_has_its_sensitivity_beside_the_limits_that_are_asked() -> None:
    found = [one.title for one in assess(tower(2), limits=["tilt"], friction=0.6)]
    assert len(found) == 4
    assert "friction" in found[2]
    assert "size of the joints" in found[3]
    assert len(assess(tower(2), limits=["tilt"], friction=0.3, seismic=(0.4, 0.0))) == 3  # falls


@pytest.mark.usefixtures("unpainted")
def test_a_sheet_says_what_a_limit_is_where_it_has_one_and_notes_once() -> None:
    limits = ["load seismic:1,0", "load seismic:0,1"]
    found = assess(tower(3), limits=limits, sensitivity=False, seismic=0.02, friction=0.6)
    alone, more = (document_of(answers, TitleBlock()) for answers in (found[:1], found))
    texts = [[x for one in made.sections for x in one.parts if isinstance(x, str)]
             for made in (alone, more)]  # fmt: skip
    assert [any(x.startswith("A limit is a pair") for x in each) for each in texts] == [False, True]
    summary = [x for x in more.sections[0].parts if isinstance(x, str)]
    assert sum("shakes" in x for x in summary) == 1
    asked = alone.sections[1].parts[0]
    assert isinstance(asked, Mapping)
    assert "shakes" in asked["Earthquake"]
    assert "Notes" not in asked
