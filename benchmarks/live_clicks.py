"""Whether clicks and touches do what was meant: ``python -m benchmarks.live_clicks``.

Twenty actions on each of four models, with a mouse and with a finger: a block becomes a support
or is freed, is taken out, is pushed, or a support is moved. What was meant is the block that the
page names beside the pointer; what was done is what its list of changes says. Each is undone.
"""

from __future__ import annotations

import argparse
import random
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np

import drystone
from benchmarks.curved import curved_vault
from drystone import io
from drystone.assembly import Assembly
from drystone.live.serving import Live
from drystone.models import arch, dome, vault
from tests.page.browser import Browser, BrowserError, Tab, executable, running

MODELS = {"arch": arch, "vault": vault, "dome": dome, "curved": curved_vault}
MODES = {
    "support": ": a click",
    "remove": ": a click takes it out",
    "push": ": drag to push it",
    "move": ": drag to move it",
}
"""What the page says beside the pointer where an action of a mode is possible."""
APART = 15.0
"""[pixels] between the places that are tried: a block of a picture is as wide, or no target."""
TIP = "document.getElementById('tip')"


def main() -> None:
    """Print how many actions of each model did what was meant, and each that did not."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--actions", type=int, default=20)
    parser.add_argument("--model", choices=MODELS, nargs="*", default=list(MODELS))
    chosen = parser.parse_args()
    program = executable()
    if program is None:
        parser.error("there is no Chromium on this machine")
    with running(program) as browser, tempfile.TemporaryDirectory() as folder:
        for name in chosen.model:
            path = Path(folder) / f"{name}.json"
            blocks: Assembly = MODELS[name]()
            io.write(drystone.Model.of(blocks, friction=0.9), path)
            with Live(path, port=0) as live:
                for touch in (False, True):
                    how = "finger" if touch else "mouse"
                    right = actions(browser, live, touch=touch, count=chosen.actions)
                    print(f"{name:8}{len(blocks):6} blocks  {how:8}{right} of {chosen.actions}")


def actions(browser: Browser, live: Live, *, touch: bool, count: int) -> int:
    """How many actions did what was meant."""
    size = (390, 844) if touch else (1000, 700)
    tab = browser.open(live.link, size=size, touch=touch)
    tab.until("document.getElementById('headline').className === 'good'")
    draw = random.Random(0)
    right = 0
    for number in range(count):
        mode = list(MODES)[number % len(MODES)]
        tab.run(f"document.querySelector('[data-mode={mode}]').click()")
        place = spot(tab, draw, MODES[mode])
        if place is None:
            print(f"  {mode}: no block was found under the pointer")
            continue
        x, y, block = place
        act(tab, x, y, far=30 if mode in ("push", "move") else 0, touch=touch)
        with suppress(BrowserError):  # nothing was done
            tab.until("document.getElementById('live-changes').textContent !== ''", 5.0)
        changes = tab.text("#live-changes")
        if block in changes:
            right += 1
        else:
            print(f"  {mode} at {x:.0f}, {y:.0f}: meant {block}, done: {changes[:80]}")
        tab.run("document.getElementById('reset').click()")
        tab.until("document.getElementById('live-changes').textContent === ''", patience=20.0)
    tab.close()
    return right


def spot(tab: Tab, draw: random.Random, words: str) -> tuple[float, float, str] | None:
    """A place of the picture at which the page says that an action is possible, and the block."""
    left, top, wide, high = tab.run("""(() => {
      const box = document.getElementById('view').getBoundingClientRect();
      return [box.x, box.y, box.width, box.height];
    })()""")
    across, down = (np.arange(0.1 * size, 0.9 * size, APART) for size in (wide, high))
    # each once, in any order: of places drawn one by one, 400 missed the springers of an arch;
    # on whole pixels, as a browser tells presses, not moves, in whole ones
    places = [(round(left + dx), round(top + dy)) for dx in across for dy in down]
    draw.shuffle(places)
    for x, y in places:
        if tab.run(f"document.elementFromPoint({x}, {y}) !== document.getElementById('view')"):
            continue
        tab.run(f"Object.assign({TIP}, {{hidden: false, textContent: '?'}})")
        tab.mouse("mouseMoved", x, y)
        # the page tells what is there once the pointer rests, or hides the tip
        tab.until(f"{TIP}.hidden || {TIP}.textContent !== '?'", 5.0)
        told = tab.run(f"{TIP}.hidden ? '' : {TIP}.textContent")
        if words in told:
            return x, y, told.split(": ")[0]
    return None


def act(tab: Tab, x: float, y: float, *, far: float, touch: bool) -> None:
    """Click or tap; drag ``far`` pixels to the right where that is not zero."""
    if touch:
        tab.touch("touchStart", (x, y))
        if far:
            tab.touch("touchMove", (x + far, y))
        tab.touch("touchEnd")
    else:
        tab.mouse("mousePressed", x, y, button="left", clickCount=1)
        if far:
            tab.mouse("mouseMoved", x + far, y, button="left", buttons=1)
        tab.mouse("mouseReleased", x + far, y, button="left", clickCount=1)
    tab.frames()


if __name__ == "__main__":
    main()
