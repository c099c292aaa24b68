"""``drystone poses``: the poses on a plane in which one block stands."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from drystone.cli.command import command
from drystone.cli.model_input import Source
from drystone.cli.offered import MODEL, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures


@command(
    "drystone poses arch.json --block voussoir-03 --html poses.html",
    "drystone poses arch.json --block voussoir-06 --json",
)
def poses(
    *,
    source: Source,
    block: Annotated[
        str | None, Option("Which block of several; the only free one when left out.", MODEL)
    ] = None,
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """Find the poses on a plane in which one block stands, with their shares and tilts.

    The share is how often it ends so when it is put down at random. Exit code 0: it stands. 2: bad
    input.
    """
    from drystone.poses import find_poses  # the program starts fast

    waiting.stage("read", f"reading {source.name}")
    found = find_poses(source.place, block=block, **source.how)
    return Told(found, files=partial(pictures.of, found))
