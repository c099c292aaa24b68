"""The widget of a notebook: its script in a real browser, its model in Python, and back."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import drystone
from drystone.models import arch
from drystone.view import interact, notebook
from tests.page.browser import Browser, Tab

if find_spec("anywidget") is None:  # slow to import
    pytest.skip("no anywidget, the extra 'notebook'", allow_module_level=True)
MODEL = drystone.Model.of(arch(0.2, 8), friction=0.7)
SYNCED = ("page", "height", "sliders", "values", "names", "picked", "picked_joint", "trouble")

# The model as notebooks give it to a widget: changes are heard on both sides.
STUB = """
window.model = {
  values: JSON.parse(document.getElementById("state").textContent), heard: {}, saved: 0,
  get(key) { return this.values[key]; },
  set(key, value) {
    if (JSON.stringify(this.values[key]) === JSON.stringify(value)) return;
    this.values[key] = value;
    for (const hear of this.heard[`change:${key}`] ?? []) hear();
  },
  on(name, hear) { (this.heard[name] ??= []).push(hear); },
  save_changes() { this.saved += 1; },
};
"""


def told(tab: Tab, live: Any) -> None:
    """What the browser has, in Python."""
    for key in ("values", "picked", "picked_joint"):
        setattr(live, key, tab.run(f"model.get('{key}')"))


def shown(tab: Tab, live: Any, key: str) -> None:
    """What Python has, in the browser."""
    tab.run(f"model.set('{key}', {json.dumps(getattr(live, key))})")


def test_sliders_and_picked_blocks_reach_python_and_python_reaches_the_page(
    browser: Browser, tmp_path: Path
) -> None:
    live = interact(lambda friction: drystone.check(MODEL.with_friction(friction)),
                    friction=(0.0, 0.9, 0.333))  # fmt: skip
    state = json.dumps({key: getattr(live, key) for key in SYNCED}).replace("<", "\\u003c")
    path = tmp_path / "notebook.html"
    path.write_text(
        "<!doctype html><meta charset=utf-8><link rel=icon href='data:,'>"
        "<div id=cell style='display:none'></div>"
        f"<script type='application/json' id=state>{state}</script><script>{STUB}</script>",
        encoding="utf-8",
    )
    tab = browser.open(path, size=(700, 600))
    script = Path(notebook.__file__).with_name("static") / "widget.js"
    source = json.dumps(script.read_text(encoding="utf-8"))
    tab.run(
        f"import(URL.createObjectURL(new Blob([{source}], {{ type: 'text/javascript' }})))"
        ".then((module) => { module.default.render({ model,"
        " el: document.getElementById('cell') }); })"
    )
    tab.until("model.saved > 0")  # the page in the frame has drawn unseen: its size was none
    tab.run("window.heard = []")
    tab.run("document.getElementById('cell').style.display = ''")
    assert tab.text("output") == "0.333"  # not the nearest step of the slider

    # a slider asks Python, whose answer is another page, seen as a whole as the one before
    tab.slide("input[type=range]", 0.09)
    told(tab, live)
    assert live.values == {"friction": 0.09}
    assert live.subject.verdict == "unstable"
    tab.run("addEventListener('message', ({ data }) => heard.push(data.block))")
    shown(tab, live, "page")

    # Python picks a block: the page selects it and says so
    block = live.names.index("voussoir-03")
    tab.until(f"(model.values.picked = '', {PICK}, heard.includes({block}))")  # once it is there

    # a click in the frame picks another one
    left, top, width = tab.run(
        "(({ x, y, width }) => [x, y, width])"
        "(document.querySelector('iframe').getBoundingClientRect())"
    )
    for down in 3 * [*range(100, 240, 10)]:  # below the head of the page
        tab.run("[heard.length, window.since] = [0, performance.now()]")
        tab.press(left + 0.65 * width, top + down)
        tab.until("heard.length > 0 || performance.now() > since + 1000")  # a click may be lost
        told(tab, live)
        if live.picked not in ("", "voussoir-03"):
            break
    assert live.picked in MODEL.assembly.names
    assert live.picked != "voussoir-03"

    # what goes wrong in Python is told
    live.values = {"friction": -1.0}
    shown(tab, live, "trouble")
    assert "friction" in tab.text("p[role=alert]")
    assert tab.complaints() == []
    assert tab.requests() == []
    tab.close()


PICK = "model.set('picked', 'voussoir-03')"
