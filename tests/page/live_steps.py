"""What the tests of the live page do again and again."""

from __future__ import annotations

import json

from drystone.live.serving import Live
from tests.page.browser import Tab


def verdict(tab: Tab, wanted: str) -> str:
    """Wait for the whole verdict; the sentence that the page then says."""
    tab.until(f"document.getElementById('headline').className === '{wanted}'")
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
