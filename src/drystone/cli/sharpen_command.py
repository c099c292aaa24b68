"""``drystone sharpen``: wedges of two planes from joints with tension."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.mend_command import ChangedFiles, margins
from drystone.cli.model_input import Finding, Subject
from drystone.cli.offered import Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting


@command(
    "drystone sharpen arch.json --friction 0.7 --out wedged.json",
    "drystone sharpen arch.json --most 50 --keep springer-left --html wedged.html",
)
def sharpen(
    *,
    subject: Subject,
    finding: Finding,
    step: Annotated[
        float | None,
        Option(
            "Degrees by which joints with tension are sharpened in each round (10).",
            kind=kinds.POSITIVE,
            expert=True,
        ),
    ] = None,
    most: Annotated[
        float | None, Option("Largest sharpness in degrees (60).", kind=kinds.POSITIVE)
    ] = None,
    close: Annotated[
        float | None,
        Option(
            "Accuracy of the sharpness of each wedge, in degrees (0.5).",
            kind=kinds.POSITIVE,
            expert=True,
        ),
    ] = None,
    keep: Annotated[
        tuple[str, ...],
        Option(
            "Blocks whose joints stay plane: names and patterns, separated by commas, as for "
            "--supports. Can be given several times.",
            metavar="BLOCK",
        ),
    ] = (),
    changed: ChangedFiles,
    waiting: Waiting,
) -> Told:
    """Make wedges of two planes from plane joints with tension, until the model stands.

    Wedges that are not needed are then made plane again, and each other one as flat as possible.
    --html and --png show it with the edges of the model before.

    Exit code 0: it stands, already or sharpened. 1: it does not. 2: bad input.
    130: stopped by Ctrl-C, with what stood so far.
    """
    given = {"step": step, "most": most, "close": close}
    asked: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    stands_at = margins(changed.margin)
    from drystone import design  # work is imported when there is some

    model = subject.prepared(waiting, finding)
    chosen = design.SharpenOptions(margin=stands_at, keep=keep, **asked)
    waiting.stage("sharpen", "sharpening")
    with waiting.keywords(changed.time_limit) as common:
        found = design.sharpen(model, options=chosen, **common)
    return Told(found, notes=model.notes, files=partial(changed.files, found))
