"""The live page in a real browser: sliders, clicks, drags, undo, and the verdicts that follow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import drystone
from drystone import io
from drystone.live.serving import Live
from drystone.models import box, tower
from tests.page.browser import Browser, Tab
from tests.page.live_steps import choose, leave, verdict

EVIL = "</script><img src=x onerror=\"alert('x')\"><b>&amp;"
PROPPED = "voussoir-09"
"""A voussoir with which the arch stands at 9 degrees if it is a support."""


@pytest.fixture
def tab(browser: Browser, live: Live) -> Iterator[Tab]:
    made = browser.open(live.link, size=(1000, 700))
    verdict(made, "good")
    yield made
    leave(made, live)


def test_the_arch_stands_at_8_degrees_and_falls_at_9(tab: Tab) -> None:
    tab.slide("#tilt", 8)
    tab.until("document.getElementById('asked').textContent.includes('tilt 8 deg')")
    assert verdict(tab, "good").startswith("Stands")
    tab.slide("#tilt", 9)
    fallen = verdict(tab, "bad")
    assert fallen.startswith("Falls")

    choose(tab, PROPPED)
    tab.click("#block-actions button")
    assert verdict(tab, "good").startswith("Stands")
    assert f"{PROPPED} is a support" in tab.text("#live-changes")
    tab.click("#undo")
    assert verdict(tab, "bad") == fallen
    tab.click("#redo")
    verdict(tab, "good")
    tab.click("#reset")
    tab.until("!document.getElementById('asked').textContent.includes('tilt')")
    verdict(tab, "good")
    assert tab.text("#live-changes") == ""


def take_out_the_crown(tab: Tab) -> tuple[float, float]:
    """Click on a block in the middle of the picture; where it is."""
    tab.click("[data-mode=remove]")
    x, y = tab.run("""(() => {
      const box = document.getElementById('view').getBoundingClientRect();
      return [box.x + box.width / 2, box.y + box.height / 2];
    })()""")
    for down in range(-300, 300, 12):
        tab.press(x, y + down)
        if tab.text("#live-changes"):
            return x, y + down
    raise AssertionError("no block is there")


def test_a_block_is_taken_out_by_a_click_and_put_back(tab: Tab) -> None:
    take_out_the_crown(tab)
    assert "is out" in tab.text("#live-changes")
    verdict(tab, "bad")
    tab.click("#live-changes button")
    verdict(tab, "good")
    assert tab.text("#live-changes") == ""


def test_a_drag_pushes_a_block_with_a_force(tab: Tab) -> None:
    x, y = take_out_the_crown(tab)
    verdict(tab, "bad")
    tab.click("#undo")
    verdict(tab, "good")
    tab.click("[data-mode=push]")
    tab.mouse("mousePressed", x, y, button="left", clickCount=1)
    tab.mouse("mouseMoved", x + 60, y, button="left", buttons=1)
    words = tab.text("#push-arrow text")
    tab.mouse("mouseReleased", x + 60, y, button="left", clickCount=1)
    assert words.endswith(" N")
    assert float(words.removesuffix(" N")) > 0.0
    tab.until("document.querySelector('#live-changes input') !== null")
    tab.run("""(() => {
      const e = document.querySelector('#live-changes input');
      e.value = 5000; e.dispatchEvent(new Event('change'));
    })()""")
    verdict(tab, "bad")
    tab.click("#undo")
    tab.click("#undo")
    verdict(tab, "good")


def test_what_cannot_be_is_refused_in_words_and_the_next_wish_is_answered(browser, live) -> None:
    tab = browser.open(live.link)
    verdict(tab, "good")
    tab.slide("#friction-number", -1)
    tab.until("document.getElementById('live-trouble').textContent.includes('give 0 or more')")
    tab.until("document.getElementById('friction-number').value !== '-1'")  # it is not kept
    tab.slide("#tilt-number", 9)  # and refuses nothing else
    verdict(tab, "bad")
    assert tab.run("document.getElementById('live-trouble').hidden")
    tab.run("document.getElementById('tilt-number').value = ''")
    tab.run("document.getElementById('tilt-number').dispatchEvent(new Event('change'))")
    verdict(tab, "good")
    assert tab.run("document.getElementById('tilt').value") == "0"
    tab.slide("#friction-number", 0.05)
    verdict(tab, "bad")
    assert tab.run("document.getElementById('live-trouble').hidden")
    assert all("400" in one for one in tab.complaints())  # the browser notes the refusal
    tab.close()


def test_load_cases_side_by_side_and_the_edge(tab: Tab) -> None:
    tab.slide("#tilt", 9)
    verdict(tab, "bad")
    tab.run("document.getElementById('cases-box').open = true")
    tab.run("document.getElementById('case-name').value = 'quake'")
    tab.run("document.getElementById('case-form').requestSubmit()")
    tab.until("document.querySelector('#cases .UNSTABLE') !== null")
    assert "tilt 9° towards 0°" in tab.text("#cases")
    tab.click("#reset")
    verdict(tab, "good")
    tab.click("#cases button")
    verdict(tab, "bad")

    tab.key("1")  # from the front one looks along y
    tab.click("#edge")
    tab.until("document.getElementById('edge-answer').textContent.includes('stands up to')")
    assert "Towards 90" in tab.text("#edge-answer")
    verdict(tab, "good")


def test_the_file_is_watched_and_names_stay_text(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    blocks = (box((1, 1, 1), name="base"), box((1, 1, 1), (0, 0, 1), name=EVIL))
    made = drystone.Assembly(blocks).with_fixed([0])
    io.write(drystone.Model.of(made, friction=0.5), path)
    with Live(path, port=0) as live:
        tab = browser.open(live.link)
        verdict(tab, "good")
        choose(tab, EVIL)
        assert EVIL in tab.text("#block-actions")
        assert tab.run("document.querySelectorAll('img[src=x]').length") == 0
        path.write_text('{"blocks": [\n,]}')
        tab.until("document.getElementById('live-trouble').textContent.includes('line 2')")
        verdict(tab, "good")
        io.write(drystone.Model.of(tower(5), friction=0.5), path)
        tab.until("document.getElementById('asked').textContent.includes('5 blocks')")
        tab.until("document.getElementById('live-trouble').hidden")
        verdict(tab, "good")
        leave(tab, live)
