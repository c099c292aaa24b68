"""The live page by mouse and touch: only what was meant is done; what is not done is said."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import drystone
from drystone import io
from drystone.live.serving import Live
from drystone.models import box, prism
from tests.page.browser import Browser, Tab
from tests.page.live_steps import choose, leave, says, seen_from_the_front, verdict


def place_of(tab: Tab, live: Live, name: str) -> tuple[float, float]:
    """Where a block is in the window, seen from the front."""
    blocks = io.read(live.desk.file).assembly
    middle = 0.5 * (blocks.bounds[:, 0].min(axis=0) + blocks.bounds[:, 1].max(axis=0))
    return seen_from_the_front(tab, blocks.centroid[blocks.index(name)] - middle)


def untouched(tab: Tab) -> bool:
    """Whether nothing was changed since the page was opened."""
    return tab.text("#live-changes") == "" and bool(
        tab.run("document.getElementById('undo').disabled")
    )


def test_only_a_click_takes_a_block_out_and_a_double_click_takes_one(
    browser: Browser, live: Live
) -> None:
    tab = browser.open(live.link, size=(760, 480))
    verdict(tab, "good")
    x, y = place_of(tab, live, "voussoir-06")
    for mode in ("remove", "support"):
        tab.click(f"[data-mode={mode}]")
        tab.mouse("mousePressed", x, y, button="left", clickCount=1)
        for far in (20, 40, 0):  # turned, and back
            tab.mouse("mouseMoved", x + far, y, button="left", buttons=1)
        tab.mouse("mouseReleased", x, y, button="left", clickCount=1)
        tab.frames()
        assert untouched(tab)
    tab.click("[data-mode=remove]")
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            tab.mouse(kind, x, y, button="left", clickCount=count)
    verdict(tab, "bad")
    assert tab.text("#live-changes").count(" is out") == 1
    tab.click("#undo")
    verdict(tab, "good")
    assert untouched(tab)
    leave(tab, live)


@pytest.fixture
def phone(browser: Browser, live: Live) -> Tab:
    tab = browser.open(live.link, size=(390, 844), touch=True)
    verdict(tab, "good")
    return tab


def test_two_fingers_on_a_block_zoom_and_a_tap_opens_its_card(phone: Tab, live: Live) -> None:
    x, y = place_of(phone, live, "voussoir-06")
    for mode in ("remove", "push", "support"):
        phone.click(f"[data-mode={mode}]")
        phone.touch("touchStart", (x, y))
        phone.touch("touchMove", (x + 10, y))
        phone.touch("touchStart", (x + 10, y), (x + 40, y))
        phone.touch("touchMove", (x + 10, y), (x + 90, y))
        phone.touch("touchEnd")
        phone.frames()
        phone.until("document.getElementById('live-changes').textContent === ''")
        assert untouched(phone)
    phone.click("[data-mode=push]")
    x, y = place_of(phone, live, "voussoir-06")
    phone.touch("touchStart", (x, y))
    time.sleep(0.8)  # a finger that rests
    phone.touch("touchEnd")
    phone.until("document.getElementById('block-actions').textContent.includes('voussoir-06')")
    assert untouched(phone)
    leave(phone, live)


def test_what_is_not_done_is_said_where_one_looks(phone: Tab, live: Live) -> None:
    x, y = place_of(phone, live, "springer-left")
    phone.click("[data-mode=push]")
    phone.touch("touchStart", (x, y))
    phone.touch("touchMove", (x + 30, y))
    phone.touch("touchEnd")
    phone.until("!document.getElementById('tip').hidden")
    assert phone.text("#tip") == "springer-left: a support: not pushed"
    assert untouched(phone)

    assert phone.run("document.getElementById('controls').checkVisibility()") is False  # folded
    phone.slide("#friction-number", -1)
    phone.until("document.getElementById('live-trouble').textContent.includes('give 0 or more')")
    assert phone.run("document.getElementById('live-trouble').checkVisibility()")
    assert all("400" in one for one in phone.complaints())  # the browser notes the refusal
    phone.close()


def test_a_card_has_the_friction_of_the_answer(browser: Browser, live: Live) -> None:
    tab = browser.open(live.link, size=(760, 480))
    verdict(tab, "good")
    tab.slide("#friction-number", 0.8)
    says(tab, "asked", "friction 0.8")
    choose(tab, "voussoir-06")
    tab.click("#card td button")
    assert "friction coefficient0.8" in tab.text("#card")
    leave(tab, live)


def test_a_card_has_the_edges_that_touch_as_well(browser: Browser, tmp_path: Path) -> None:
    slab = prism([(0, 0), (0.17, 0), (1.17, 1.732), (1.04, 1.807)], (-0.2, 0.2), "slab")
    wall = box((1, 4, 4), (float(slab.bounds[1, 0]), -2, 0), "wall")
    blocks = drystone.Assembly((box((20, 8, 1), (-10, -4, -1), "floor"), wall, slab))
    path = tmp_path / "slab.json"
    io.write(blocks.with_fixed([0, 1]), path)
    with Live(path, port=0, how={"friction": 0.9}) as live:
        tab = browser.open(live.link, size=(760, 480))
        verdict(tab, "good")
        choose(tab, "slab")
        tab.click("#card td button[title='joint with wall']")  # the edge that it leans with
        assert "friction coefficient0.9" in tab.text("#card")
        leave(tab, live)
