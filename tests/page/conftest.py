"""One browser for all pages that a process opens."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from drystone.live.serving import Live
from drystone.view import save_page
from tests.page.browser import Browser, Tab, executable, running
from tests.unit.live.live_client import served_arch


@pytest.fixture(scope="package")
def chromium() -> Iterator[Browser]:
    """One for all; it ends with the tests of this folder, whatever else the process tests then."""
    program = executable()
    if program is None:
        pytest.skip("no Chromium on this machine")
    with running(program) as made:
        yield made


@pytest.fixture
def browser(chromium: Browser) -> Iterator[Browser]:
    """The browser; a tab that a test left open would draw on, and is closed."""
    yield chromium
    for tab in tuple(chromium.tabs):
        tab.close()


@pytest.fixture(scope="package")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """A server of the arch."""
    with served_arch(tmp_path_factory.mktemp("live")) as made:
        yield made


@pytest.fixture
def opened(browser: Browser, tmp_path: Path) -> Iterator[Callable[..., Tab]]:
    """Opens the page of a subject; afterwards nothing may have been complained about or fetched.

    A function writes its page itself.
    """
    tabs = []

    def open_page(subject: object, **how: object) -> Tab:
        path = tmp_path / f"page-{len(tabs)}.html"
        if callable(subject):
            subject(path)
        else:
            save_page(subject, path)  # type: ignore[arg-type]
        tabs.append(browser.open(path, **how))  # type: ignore[arg-type]
        return tabs[-1]

    yield open_page
    for tab in tabs:
        assert tab.complaints() == []
        assert tab.requests() == []
        tab.close()
