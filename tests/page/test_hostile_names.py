"""Names that were made to do harm, in every kind of page: nothing runs, the page keeps its form."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import drystone
from drystone import io
from drystone.limits import LimitOptions
from drystone.live.serving import Live
from drystone.report import TitleBlock, save_instructions, save_joints, write_report
from drystone.sequence import interlocking
from drystone.view import Frame, save_page
from tests.page.browser import Browser, Tab
from tests.page.hostile_names import NAMES, hostile_model
from tests.page.live_steps import choose, leave, verdict

MODEL = hostile_model()
FALLING = MODEL.with_load((5.0, 0.0, -9.81))
HELD = MODEL.with_supports(list(range(1, len(MODEL.assembly), 2)))
"""Falls too: every other block is a support."""


def unharmed(tab: Tab) -> None:
    """No handler ran, no element came out of a name, and nothing reaches beyond the window."""
    assert tab.run("window.fired") is None
    made = "img[src=x], iframe[srcdoc], svg[onload], [onfocus], [onmouseover], [autofocus]"
    assert tab.run(f"document.querySelectorAll({made!r}).length") == 0
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize(
    ("model", "size"),
    [(MODEL, (1000, 700)), (FALLING, (390, 800)), (HELD, (1000, 700))],
    ids=["stands", "falls", "held"],
)
def test_the_page_shows_names_as_text(
    opened: Callable[..., Tab], model: drystone.Model, size: tuple[int, int]
) -> None:
    tab = opened(drystone.check(model), size=size)
    shown = "document.querySelectorAll('#layers input:not(:checked)')"
    tab.run(f"{shown}.forEach((one) => one.click())")
    tab.key(".")  # the first block, and then the next
    for name in NAMES:
        tab.key(".")
        length = tab.run("document.querySelector('#card h2').textContent.length")
        assert length == len(f"Block {name}")
        assert tab.run("document.querySelector('#card h2').offsetHeight") < 200
        tab.run("document.querySelectorAll('#card button').forEach((one) => one.focus())")
        unharmed(tab)
    assert tab.run("document.getElementById('view').getBoundingClientRect().height") > 200


@pytest.mark.parametrize("save", [save_joints, save_instructions, save_page])
def test_reports_and_instructions_show_names_as_text(
    opened: Callable[..., Tab], save: Callable[..., None]
) -> None:
    subject = drystone.check(MODEL) if save is save_joints else drystone.plan(MODEL)
    tab = opened(lambda path: save(subject, path), size=(1000, 700))
    unharmed(tab)
    columns = "[...document.querySelectorAll('tbody tr')].map((row) => row.offsetHeight)"
    assert max(tab.run(columns), default=0) < 120
    edges = "[...document.querySelectorAll('td')].map((one) => one.getBoundingClientRect().right)"
    assert max(tab.run(edges), default=0) <= 1000


def test_a_calculation_report_shows_names_as_text(opened: Callable[..., Tab]) -> None:
    coarse = LimitOptions(width=5.0, scan=1, equilibrium_only=True)
    answers = [drystone.limit_tilt(MODEL, options=coarse), interlocking(MODEL)]
    about = TitleBlock(project=NAMES[0], client=NAMES[1], author=NAMES[6], number=NAMES[3])
    tab = opened(lambda path: write_report(answers, path, about=about), size=(1000, 700))
    unharmed(tab)


def test_a_notebook_shows_names_as_text(opened: Callable[..., Tab]) -> None:
    for text in (Frame(MODEL)._repr_html_(), drystone.check(MODEL)._repr_html_()):
        page = f"<!doctype html><meta charset=utf-8>{text}".encode("utf-8", "backslashreplace")
        tab = opened(lambda path, page=page: path.write_bytes(page), size=(390, 800))
        assert tab.run("document.documentElement.scrollWidth") <= 390
        assert tab.run("window.fired") is None
        assert tab.run("document.querySelectorAll('img[src=x]').length") == 0


def test_the_live_page_shows_names_as_text(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    io.write(MODEL, path)
    with Live(path, port=0) as live:
        tab = browser.open(live.link, size=(1000, 700))
        verdict(tab, "good")
        for name in NAMES[:8]:
            choose(tab, name)
            unharmed(tab)
        leave(tab, live)
