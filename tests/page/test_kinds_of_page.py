"""Every kind of page opens in a real browser, and its controls change nothing into an error."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

import drystone
from drystone.answer import Answer
from drystone.design import Changed, MendOptions, find_mends
from drystone.fall import Film
from drystone.limits import limit_thickness, tilt_sweep
from drystone.loads import LoadCase
from drystone.models import arch, shelf, tower
from drystone.report import save_instructions, save_joints
from drystone.sequence import PlanOptions, Robot, Rules, ScaffoldOptions, plan, scaffolding
from drystone.settlement import move_supports, push, support_response
from drystone.view import Frame
from drystone.view.subjects import Subject
from tests.page.browser import Tab

STACK = drystone.Model.of(tower(3), friction=0.5)
ARCH = drystone.Model.of(arch(0.2, 6), friction=0.7)
WEAK = ScaffoldOptions(limit=450.0)
SINKING = {"springer-right": (0.0, 0.0, -0.01)}


def sideways(size: float) -> LoadCase:
    return LoadCase.seismic(STACK.assembly, size)


def on_ropes() -> Any:
    one = PlanOptions(rules=Rules(hands=1))
    propped = drystone.plan(arch(0.3, 5), friction=0.6, options=one)
    return scaffolding(propped, "rope", options=WEAK)


def film() -> Film:
    """Two blocks that slide off the lowest one, made by hand: no engine is needed."""
    positions = np.zeros((3, 3, 6))
    positions[1, 1:, 0], positions[2, 1:, 0], positions[2, 1:, 2] = 0.6, 1.5, -1.0
    return Film(STACK, np.array([0.0, 0.5, 1.0]), positions, lies=True, engine="by hand")


def mended() -> Any:
    light = replace(STACK.assembly.blocks[2], density=1200.0)
    blocks = (*STACK.assembly.blocks[:2], light)
    after = drystone.Model.of(replace(STACK.assembly, blocks=blocks), friction=0.5)
    return Changed.by_hand(STACK, drystone.check(after), "a lighter block").layers()


KINDS: dict[str, tuple[Callable[[], Any], str]] = {
    "blocks": (lambda: tower(3), "3 blocks"),
    "model": (lambda: STACK, "3 blocks"),
    "stands": (lambda: drystone.check(STACK), "Stands"),
    "falls": (lambda: drystone.check(shelf(), friction=0.9), "Falls: 2 of 11 blocks"),
    "equilibrium": (lambda: drystone.solve_rbe(STACK), "Some forces balance the loads"),
    "penalty": (lambda: drystone.solve_cra_penalty(ARCH.with_friction(0.2)), ""),
    "limit of friction": (lambda: drystone.limit_friction(ARCH), "Stands down to friction 0."),
    "limit of a load": (
        lambda: drystone.limit_load(STACK, sideways(2.0)),
        "Does not stand under the load as given, only up to load factor 0.",
    ),
    "limit of thickness": (
        lambda: limit_thickness(lambda t: arch(t, 6), 0.3, 0.02, friction=0.9),
        "Stands down to thickness 0.",
    ),
    "sweep of tilts": (lambda: tilt_sweep(tower(2), 4, friction=0.3), "Stands up to 16."),
    "plan": (lambda: drystone.plan(STACK), "Can be assembled without help"),
    "plan with scaffolding": (on_ropes, "Not every stage stands"),
    "settlement of supports": (lambda: support_response(ARCH, SINKING), "Settled"),
    "supports that move far": (
        lambda: move_supports(ARCH, SINKING, to=0.02), "Stands with its supports moved by 20 mm"
    ),
    "push": (lambda: push(tower(2), friction=0.3, to=0.01), "Push: at most 0.3"),
    "followed": (lambda: drystone.settle(ARCH.with_friction(0.15)), "Falls"),
    "film": (film, "2 blocks fell in 1 s and lie"),
    "diagnosis": (lambda: drystone.diagnose(STACK.with_load((8.0, 0.0, -9.81))), "Falls: "),
    "mended": (mended, "Stands"),
}  # fmt: skip
"""What makes a subject, and how its headline begins."""


@functools.cache
def made(kind: str) -> Any:
    return KINDS[kind][0]()


def use_all_controls(tab: Tab) -> None:
    """Every picture, every stage, every motion, a block and a joint with their cards, a print."""
    presets = "[...document.querySelectorAll('[data-preset]:not(:disabled)')]"
    for number in range(tab.run(f"{presets}.length")):
        tab.run(f"{presets}[{number}].click()")
        tab.frames(1)
    if not tab.run("document.getElementById('stage-box').hidden"):
        tab.slide("#stage", tab.run("Number(document.getElementById('stage').max)"))
    if not tab.run("document.getElementById('motion-box').hidden"):
        tab.slide("#motion", 0.5)
    tab.slide("#spread", 0.5)
    tab.key(".")
    tab.run("document.querySelector('#card table button')?.click()")
    tab.frames(1)
    tab.run(
        "document.querySelectorAll('#layers input:not(:checked)').forEach((one) => one.click())"
    )
    tab.frames(1)


LIKE_OTHERS = {"model", "stands", "equilibrium", "limit of friction", "limit of a load", "plan"}
LIKE_OTHERS |= {"supports that move far", "followed", "diagnosis"}
"""Kinds whose page has the controls of another kind; ``test_page`` opens most of them, and that of
mends begins with the diagnosis."""


@pytest.mark.parametrize("kind", [one for one in KINDS if one not in LIKE_OTHERS])
def test_a_page_of_every_kind_opens_and_obeys(opened: Callable[..., Tab], kind: str) -> None:
    tab, headline = opened(made(kind)), KINDS[kind][1]
    assert tab.text("h1").startswith(headline)
    assert tab.run("document.getElementById('trouble').hidden")
    assert " blocks · free mass " in tab.text("#asked").replace("\u00a0", " ")
    use_all_controls(tab)


def test_a_mend_that_is_listed_shows_its_stage(opened: Callable[..., Tab]) -> None:
    model = STACK.with_load((8.0, 0.0, -9.81))
    tab = opened(find_mends(model, options=MendOptions(kinds=("prop",))))
    row = "document.querySelector('.chart button')"
    assert tab.text(".chart button").startswith("mend 1: ")
    assert tab.run(f"{row}.getAttribute('aria-pressed')") == "true"
    tab.slide("#stage", 0)
    assert tab.run(f"{row}.getAttribute('aria-pressed')") == "false"
    assert tab.text("h1").startswith("Falls: ")
    tab.run(f"{row}.focus()")
    tab.send("Input.dispatchKeyEvent", type="keyDown", key="Enter", code="Enter", text="\r")
    assert tab.text("h1").startswith("Mend 1: ")
    use_all_controls(tab)


def test_instructions_and_the_report_of_joints_are_read_without_a_script(
    opened: Callable[..., Tab],
) -> None:
    tab = opened(lambda path: save_instructions(drystone.plan(STACK), path))
    assert tab.text("h1") == "Assembly plan"
    assert tab.run("document.querySelectorAll('thead + tbody tr').length") == 2
    tab = opened(lambda path: save_joints(drystone.check(STACK), path), size=(390, 800))
    assert tab.run("document.querySelectorAll('figure img').length") > 0
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")


def test_a_frame_in_a_notebook_unpacks_its_page(opened: Callable[..., Tab], tmp_path: Path) -> None:
    result = drystone.check(STACK)
    for text in (Frame(result)._repr_html_(), result._repr_html_()):
        page = f"<!doctype html><script>{HEARD}</script>{text}"
        tab = opened(lambda path, page=page: path.write_text(page, encoding="utf-8"))
        tab.until("window.heard.length > 0")  # the page inside has drawn
        assert tab.run("window.heard[0].drystone") == "state"


HEARD = "window.heard = []; addEventListener('message', (one) => heard.push(one.data));"


def test_the_kinds_are_all_that_have_a_picture() -> None:
    drawn = {type(made(kind)) for kind in KINDS}
    assert all(issubclass(kind, get_args(Subject)) for kind in drawn)
    assert drawn >= set(get_args(Subject)) - {Answer}


def test_a_robot_away_from_the_blocks_is_in_the_picture(opened: Callable[..., Tab]) -> None:
    """Its base is 12 m from a tower that is 1 m wide, and no arm and no reach lead there."""
    rules = Rules(robots=(Robot("far", (-12.0, 0.0, 0.0)),))
    found = plan(tower(2), options=PlanOptions(rules=rules)).layers()
    tab = opened(replace(found, stages=found.stages[-1:]))
    tab.run("URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };")
    tab.click("#svg")
    faces = re.findall(r'<polygon points="([^"]+)"', tab.run("window.made.text()"))
    across = [float(x) for one in faces for x in re.findall(r"([-\d.]+),", one)]
    across = [x for x in across if x > 100.0]  # without the legend
    wide = tab.run("document.getElementById('view').getBoundingClientRect().width")
    assert 5.0 < max(across) - min(across) < wide / 6.0
