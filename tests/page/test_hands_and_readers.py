"""The page by touch, by keys, by a screen reader, and with a ruler."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

import drystone
from drystone.models import tower
from tests.page.browser import Tab

STACK = drystone.Model.of(tower(3), friction=0.5)
ASKED = ("button", "checkbox", "combobox", "slider", "searchbox", "textbox", "DisclosureTriangle")
"""Roles of what can be used."""


def eye(tab: Tab) -> str:
    """Where the page looks from, as its link says it."""
    tab.click("#link")
    return str(tab.run("document.getElementById('address').value")).split("#")[1]


def test_one_finger_turns_and_two_zoom_and_a_tap_opens_a_card(opened: Callable[..., Tab]) -> None:
    tab = opened(drystone.check(STACK), size=(390, 800), touch=True)
    lists = "[...document.querySelectorAll('#worst summary')].map((one) => one.textContent)"
    assert tab.run(lists) == ["Largest normal force"]  # no joint uses friction
    seen = [eye(tab)]
    tab.touch("touchStart", (150, 400))
    for x in (170, 190, 220):
        tab.touch("touchMove", (x, 410))
    tab.touch("touchEnd")
    seen.append(eye(tab))
    tab.touch("touchStart", (150, 400), (220, 400))
    for x in (140, 120, 100):
        tab.touch("touchMove", (x, 400), (370 - x, 400))
    tab.touch("touchEnd")
    seen.append(eye(tab))
    assert len(set(seen)) == 3
    tab.key("f")
    tab.frames(2)
    x, y = tab.run(
        "(() => { const r = document.getElementById('view').getBoundingClientRect();"
        " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
    )
    tab.touch("touchStart", (x, y))
    tab.touch("touchEnd")
    tab.until("document.getElementById('card').textContent !== ''")
    for told in (False, True):  # with the controls open the model has the room of what was asked
        tab.click("#fold")
        assert tab.run("document.getElementById('asked').checkVisibility()") is told


def test_keys_turn_move_zoom_and_look_from_three_sides(opened: Callable[..., Tab]) -> None:
    tab = opened(drystone.check(STACK))
    first = eye(tab)
    seen = {first}
    for key in ("ArrowLeft", "ArrowUp", "+", "-", "1", "2", "3"):
        tab.key(key)
        seen.add(eye(tab))
    assert len(seen) > 6
    for key, button in (("1", "#front"), ("2", "#side"), ("3", "#top")):
        tab.key(key)
        by_key = eye(tab)
        tab.key("ArrowLeft")
        tab.click(button)
        assert eye(tab) == by_key


def test_two_corners_are_measured(opened: Callable[..., Tab]) -> None:
    tab = opened(STACK, size=(900, 600))
    tab.run("document.getElementById('measure').click()")
    asked = "document.getElementById('measured').textContent"
    for height in range(20, 580, 20):
        tab.press(330 if "second" not in tab.run(asked) else 380, height)
        if "(" in tab.run(asked):
            break
    told = tab.run(asked)
    numbers = [float(one) for one in re.findall(r"([\d.]+) m\b", told)]
    assert numbers, told
    length, parts = numbers[0], numbers[1:]
    assert length == pytest.approx(sum(one**2 for one in parts) ** 0.5, rel=1e-3)
    assert all(one == pytest.approx(round(one), abs=1e-3) for one in parts)  # cubes of 1 m
    assert tab.text("#said") == told  # a screen reader hears it


def test_a_screen_reader_finds_the_answer_and_a_name_for_all_that_can_be_used(
    opened: Callable[..., Tab],
) -> None:
    tab = opened(drystone.check(STACK))
    tab.run("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    tab.key(".")  # a block with its card
    nodes = [
        {"role": one["role"]["value"], "name": one.get("name", {}).get("value", "")}
        for one in tab.send("Accessibility.getFullAXTree")["nodes"]
        if not one["ignored"] and "role" in one
    ]
    assert {"role": "heading", "name": "Stands"} in nodes
    assert any(one["name"] == "The model in three dimensions" for one in nodes)
    used = [one for one in nodes if one["role"] in ASKED]
    assert len(used) > 20
    assert [one for one in used if not one["name"].strip()] == []
    roles = {one["role"] for one in nodes}
    assert {"main", "complementary", "status"} <= roles
