"""Calculation reports: what stands in them, and that their hand checks hold."""

import html
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import InputError, LoadCase, Model, report
from drystone.answer import Answer
from drystone.cli import main
from drystone.models import arch, tower, vault
from drystone.report import TitleBlock, assess, write_report
from drystone.report.document import Document, Picture, Section
from drystone.report.hand_checks import balance, crown_thrust, weights
from drystone.report.report_page import html_of
from drystone.report.report_pdf import pdf_of
from drystone.report.report_sections import document_of
from drystone.report.sketches import dimensions_picture
from drystone.sequence import plan


@pytest.fixture(scope="module")
def bridge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "bridge.json"
    drystone.write(arch(0.2, 7), path)
    return path


@pytest.fixture(scope="module")
def answers(bridge: Path) -> list[Answer]:
    return assess(bridge, friction=0.7, load="voussoir-02:0.3kN", limits=["friction --scaled"])


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
        "0, 0, -300 N", "friction 0.7", "2400", "Stands down to share of friction", "reactions",
        "Proof, computed again", "thrust at the crown", "positive in compression", "kern",
    ):  # fmt: skip
        assert expected in text or expected in page, expected
    assert page.count("<svg") == 8
    assert page.count('src="data:image/png') == 5
    assert not re.search(r"https?://", page)


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
    assert again.png in [one.png for one in pictures if isinstance(one, Picture)]


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
    thrust = crown_thrust(result)
    assert thrust is not None
    assert thrust.by_hand == pytest.approx(thrust.by_joints, rel=1e-6)
    assert thrust.by_hand == pytest.approx(abs(result.reactions()["force"][0, 0]), rel=1e-6)
    assert crown_thrust(drystone.check(tower(3))) is None
    across = crown_thrust(drystone.check(vault(courses=7, blocks=2), friction=0.7))
    assert across is not None
    assert across.by_hand == pytest.approx(across.by_joints, rel=1e-6)


def test_a_report_on_what_falls_has_the_mechanism_and_why(tmp_path: Path) -> None:
    answers = assess(tower(2), friction=0.3, seismic=(0.4, 0.0))
    assert answers[0].title.startswith("Falls")
    write_report(answers, tmp_path / "falls.html")
    text = (tmp_path / "falls.html").read_text(encoding="utf-8")
    assert "UNSTABLE" in text
    assert html.escape(answers[1].sentences()[1].text[1:]) in text


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
    pages = [[page for text, page in drawn if text == one] for one in ("2 Signs", "a picture")]
    assert pages[0] == pages[1]
    assert len(pages[0]) == 6


def test_a_plan_can_be_reported(tmp_path: Path) -> None:
    write_report(plan(Model.of(tower(2), friction=0.6)), tmp_path / "plan.html")
    assert "Loads" in (tmp_path / "plan.html").read_text(encoding="utf-8")
