"""The server that the tests of this folder share, and a window of it for each test."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from drystone.live.serving import Live
from tests.unit.live.live_client import Window, served_arch, write_arch


@pytest.fixture(scope="package")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the file of the arch, whether it is served or not."""
    made = tmp_path_factory.mktemp("live")
    write_arch(made)
    return made


@pytest.fixture(scope="package")
def live(folder: Path) -> Iterator[Live]:
    """A server of the arch, whose file is in the folder."""
    with served_arch(folder) as made:
        yield made


@pytest.fixture
def window(live: Live, request: pytest.FixtureRequest) -> Iterator[Window]:
    made = Window(live, f"window-{abs(hash(request.node.name))}")
    yield made
    made.close()
