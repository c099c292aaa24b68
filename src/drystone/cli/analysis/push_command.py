"""``drystone push``: load against displacement, until the load is zero again."""

from __future__ import annotations

from typing import Annotated

from drystone.base.errors import InputError
from drystone.cli.analysis import large_answer
from drystone.cli.analysis.large_answer import Curves
from drystone.cli.base import kinds
from drystone.cli.base.answer import Answer
from drystone.cli.base.command import Argument, Option, command
from drystone.cli.base.waiting import Waiting
from drystone.cli.inputs import loading
from drystone.cli.inputs.model_input import Subject
from drystone.cli.inputs.options import TimeLimit

SIDEWAYS = "seismic:1,0"


@command(
    "drystone push arch.json --png push.png --html push.html",
    "drystone push arch.json seismic:0,1 --to 0.01 --curve push.csv",
)
def push(
    *,
    subject: Subject,
    live: Annotated[
        str,
        Argument(
            "[CASE]",
            "The load that grows: a load case of the file by name, seismic:KX,KY, or "
            "BLOCK:WHAT[@X,Y,Z] as for --load (seismic:1,0).",
        ),
    ] = SIDEWAYS,
    to: Annotated[
        float | None,
        Option("Displacement at which it ends, m (the mean size of a block).", kind=kinds.POSITIVE),
    ] = None,
    lose_friction: Annotated[
        bool, Option("Let all friction decay to zero instead of a load that grows.")
    ] = False,
    pace: Annotated[
        float,
        Option(
            "Length of the steps, divided by the default (1).", kind=kinds.POSITIVE, expert=True
        ),
    ] = 1.0,
    time_limit: TimeLimit = None,
    wanted: Curves,
    waiting: Waiting,
) -> Answer:
    """Load against displacement, until the load is zero again: the displacement capacity.

    Exit code 0: that displacement, or the fall, was found. 1: it was not reached, or the model does
    not stand at the beginning.
    """
    if lose_friction and (live != SIDEWAYS or to is not None):
        raise InputError(
            "--lose-friction and a load that grows contradict each other",
            remedy="leave out CASE and --to",
        )
    from drystone.settlement import SettlementOptions, reduce_friction
    from drystone.settlement import push as pushed

    model = subject.prepared(waiting)
    wanted.require_through(model.assembly)
    options = SettlementOptions(pace=pace)
    notes = list(model.notes)
    with waiting.keywords(time_limit) as common:
        waiting.stage("solve", "pushing")
        if lose_friction:
            found = reduce_friction(model, options=options, **common)
        else:
            case = loading.chosen_case(live, model.assembly, model.cases, subject.gravity)
            notes += case.notes
            found = pushed(model, case, to=to, options=options, **common)
    stood = len(found.displacement) > 1
    code = 0 if stood and found.capacity is not None else 1
    return large_answer.answer(found, subject.model, notes, wanted, code)
