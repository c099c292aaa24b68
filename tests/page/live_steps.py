"""What the tests of the live page do again and again."""

from __future__ import annotations

import json
import math
from urllib.parse import parse_qs

import numpy as np

from drystone.live.serving import Live
from tests.page.browser import Tab


def verdict(tab: Tab, role: str) -> str:
    """Wait for the role of the whole verdict; the sentence that the page then says."""
    tab.until(f"document.getElementById('headline').className === '{role}'")
    return tab.text("h1")


def says(tab: Tab, name: str, words: str) -> None:
    """Wait until an element has some words."""
    tab.until(f"document.getElementById({name!r}).textContent.includes({json.dumps(words)})")


def choose(tab: Tab, name: str) -> None:
    """Open the card of a block by its name."""
    tab.run(f"document.getElementById('name').value = {json.dumps(name)}")
    tab.run("document.getElementById('find').requestSubmit()")
    tab.frames()


def leave(tab: Tab, live: Live) -> None:
    """Nothing was complained about, and nobody but the server was asked."""
    assert tab.complaints() == []
    assert all(url.startswith(f"http://127.0.0.1:{live.port}/") for url in tab.requests())
    tab.close()


def seen_from_the_front(tab: Tab, point: np.ndarray) -> tuple[float, float]:
    """Where a point, relative to the middle of the model [m], is in the window."""
    tab.key("1")
    tab.click("#link")
    view = parse_qs(str(tab.run("document.getElementById('address').value")).split("#")[1])
    distance, x, _, z = (float(one) for one in view["v"][0].split(",")[2:])
    left, top, wide, high = tab.run("""(() => {
      const box = document.getElementById('view').getBoundingClientRect();
      return [box.x, box.y, box.width, box.height];
    })()""")
    by_metre = high / (2.0 * distance * math.tan(math.radians(14.0)))  # the field of view is 28
    return left + 0.5 * wide + by_metre * (point[0] - x), top + 0.5 * high - by_metre * (
        point[2] - z
    )
