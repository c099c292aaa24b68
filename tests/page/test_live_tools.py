"""The live page in a real browser: moved supports, mends, plans, files, windows, the end."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs

import pytest

import drystone
from drystone import io
from drystone.live.serving import Live
from drystone.models import leaning_column
from tests.page.browser import Browser, Tab
from tests.page.live_steps import choose, leave, says, seen_from_the_front, verdict
from tests.unit.live.live_client import overhang


@pytest.fixture
def tab(browser: Browser, live: Live) -> Iterator[Tab]:
    made = browser.open(live.link, size=(760, 480))
    verdict(made, "good")
    yield made
    leave(made, live)


def distance_of_the_eye(tab: Tab) -> float:
    """[m] where all that is shown fills the view from the front."""
    tab.key("1")
    tab.click("#link")
    view = parse_qs(str(tab.run("document.getElementById('address').value")).split("#")[1])
    return float(view["v"][0].split(",")[2])


def test_where_clicks_change_blocks_a_joint_takes_none(tab: Tab, live: Live) -> None:
    model = io.read(live.desk.file)
    blocks = model.assembly
    middle = 0.5 * (blocks.bounds[:, 0].min(axis=0) + blocks.bounds[:, 1].max(axis=0))
    joint = 6  # its middle is under the pointer: with Look its card is opened
    at = seen_from_the_front(tab, model.contacts.centroid[joint] - middle)
    tab.press(*at)
    assert tab.run("document.querySelector('#card h2').textContent").startswith("Joint")
    tab.click("[data-mode=remove]")
    tab.mouse("mouseMoved", *at)
    tab.frames(5)
    told = tab.text("#tip")
    tab.press(*at)
    verdict(tab, "bad")
    name = next(one for one in blocks.names if told == f"{one}: a click takes it out")
    assert name in tab.text("#live-changes")


def test_a_support_is_dragged_and_the_blocks_follow(tab: Tab, live: Live) -> None:
    near = distance_of_the_eye(tab)
    tab.click("[data-mode=move]")
    blocks = io.read(live.desk.file).assembly
    middle = 0.5 * (blocks.bounds[:, 0].min(axis=0) + blocks.bounds[:, 1].max(axis=0))
    x, y = seen_from_the_front(tab, blocks.centroid[blocks.index("springer-right")] - middle)
    tab.mouse("mousePressed", x, y, button="left", clickCount=1)
    tab.mouse("mouseMoved", x + 12, y, button="left", buttons=1)
    words = tab.text("#push-arrow text")
    tab.mouse("mouseReleased", x + 12, y, button="left", clickCount=1)
    assert words.endswith(" mm")
    says(tab, "headline", "Stands with its supports")
    told = verdict(tab, "good")
    assert told.startswith(f"Stands with its supports moved by {words}: 3 hinges")
    assert "springer-right moved by" in tab.text("#live-changes")
    assert tab.text("#motion-name") == "Motion of the supports"
    assert tab.run("Number(document.getElementById('motion').value)") == 1.0

    way = "document.querySelector('#live-changes .way input')"
    assert tab.run(f"Number({way}.value)") > 0.0
    tab.run(f"{way}.value = 500; {way}.dispatchEvent(new Event('change'))")
    assert verdict(tab, "bad").startswith("Falls when the supports have moved by ")
    assert distance_of_the_eye(tab) > 1.02 * near  # what has moved is in the view
    tab.click("#undo")
    says(tab, "headline", told)
    verdict(tab, "good")
    tab.click("#undo")
    tab.until("document.getElementById('headline').textContent === 'Stands'")
    assert tab.text("#live-changes") == ""


def test_a_plan_is_played_its_order_changed_and_checked_again(tab: Tab) -> None:
    tab.click("#plan-find")
    tab.until("document.querySelectorAll('#plan li').length === 12")
    tab.until("Number(document.getElementById('stage').value) > 0")  # it plays
    names = "[...document.querySelectorAll('#plan li .name')].map((one) => one.textContent)"
    before = tab.run(names)
    tab.run("document.querySelectorAll('#plan li')[10].querySelectorAll('button')[1].click()")
    wanted = [*before[:10], before[11], before[10]]
    assert tab.run(names) == wanted
    tab.run("[...document.querySelectorAll('#plan > button')].at(-1).click()")
    tab.until("document.getElementById('task-stop').hidden")
    assert tab.run(names) == wanted
    assert "propped, " in tab.text("#plan")
    tab.click("#plan-leave")
    verdict(tab, "good")
    assert tab.run("document.getElementById('stage-box').hidden")


def test_what_is_saved_gives_the_same(
    tab: Tab, live: Live, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tab.browser.send("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    tab.slide("#friction", 0.5)
    tab.slide("#tilt", 3)
    says(tab, "asked", "tilt 3 deg")
    verdict(tab, "good")
    for button in ("model", "case", "picture"):
        tab.click(f"#save-{button}")
    wanted = ("arch-model.json", "arch-case.json")
    end = time.monotonic() + 120.0
    while not (all((tmp_path / one).exists() for one in wanted) and list(tmp_path.glob("*.png"))):
        assert time.monotonic() < end, list(tmp_path.iterdir())
        time.sleep(0.05)
    model = io.read(tmp_path / "arch-model.json")
    assert set(model.contacts.friction) == {0.5}
    case = json.loads((tmp_path / "arch-case.json").read_text())
    assert case["name"] == "tilt 3 deg"
    picture = next(tmp_path.glob("*.png")).read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 10_000

    tab.click("#save-python")
    tab.until("document.getElementById('python').value.includes('with_friction(0.5)')")
    monkeypatch.chdir(live.desk.file.parent)
    printed: list[drystone.Result] = []
    exec(tab.run("document.getElementById('python').value"), {"print": printed.append})
    assert printed[0].verdict is drystone.check(model).verdict is drystone.Verdict.STABLE


def test_two_windows_are_both_true(browser: Browser, live: Live, tab: Tab) -> None:
    other = browser.open(live.link, size=(400, 300))
    other.slide("#tilt", 12)
    tab.send("Page.bringToFront")  # a tab behind another one draws nothing
    tab.slide("#tilt", 2)
    says(tab, "asked", "tilt 2 deg")
    assert verdict(other, "bad").startswith("Falls")
    assert verdict(tab, "good").startswith("Stands")
    says(other, "asked", "tilt 12 deg")
    leave(other, live)


def test_a_mend_is_seen_made_and_undone_and_the_end_is_told(
    browser: Browser, tmp_path: Path
) -> None:
    path = tmp_path / "out.json"
    io.write(drystone.Model.of(overhang(), friction=0.9), path)
    with Live(path, port=0) as live:
        tab = browser.open(live.link, size=(760, 480))
        verdict(tab, "bad")
        says(tab, "live-state", "verdict: ")
        views = []  # that of *Fit* is the one of the first verdict, with its arrows
        for button in ("#link", "#fit", "#link"):
            tab.click(button)
            views.append(tab.run("document.getElementById('address').value"))
        assert views[0] == views[-1]
        tab.run("document.getElementById('mends-box').open = true")
        without = tab.picture("#view")
        tab.click("#mends-find")
        tab.until("document.querySelector('#mends').textContent.includes('prop')")
        tab.click("#task-stop")  # what was found stays
        tab.until("document.getElementById('task-stop').hidden")
        assert "for out" in tab.text("#mends button")
        tab.run("[...document.querySelectorAll('#mends button')]"
                ".find((one) => one.textContent.includes('prop')).focus()")  # fmt: skip
        says(tab, "legend", "the mend")
        tab.frames()
        assert tab.picture("#view") != without
        tab.run("document.activeElement.click()")
        says(tab, "mends", "made: ")
        verdict(tab, "good")
        assert "3 blocks" in tab.text("#asked")
        assert tab.run("document.getElementById('task-stop').hidden")
        tab.click("#undo")
        verdict(tab, "bad")
        assert "2 blocks" in tab.text("#asked")
        assert tab.complaints() == []
    says(tab, "live-trouble", "the server has ended")
    tab.close()


def test_joints_are_changed_and_a_block_is_cut(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "column.json"
    io.write(drystone.Model.of(leaning_column(blocks=2), friction=0.12), path)
    with Live(path, port=0) as live:
        tab = browser.open(live.link, size=(760, 480))
        verdict(tab, "bad")
        tab.run("document.getElementById('mends-box').open = true")
        tab.click("#recut-find")
        says(tab, "mends", "made: every block is free: 2 joints changed")
        verdict(tab, "good")
        choose(tab, "c02-block")
        tab.run("[...document.querySelectorAll('#block-actions button')]"
                ".find((one) => one.textContent === 'Cut it in two').click()")  # fmt: skip
        says(tab, "mends", "made: c02-block cut in two")
        verdict(tab, "good")
        assert "4 blocks" in tab.text("#asked")
        assert tab.complaints() == []
    tab.close()
