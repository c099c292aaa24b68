"""``drystone forces``: the forces of rigid-block equilibrium, of CRA and of its penalty form."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import Analysis, Of
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Written

if TYPE_CHECKING:
    from drystone.cli.told import Files
    from drystone.programs import Forces


@command(
    "drystone forces arch.json --virtual kern --html forces.html",
    "drystone forces arch.json --form penalty --gamma 1e4 --friction 0.2 --threshold 0.1",
)
def forces(
    *,
    subject: Subject,
    asked: Annotated[
        Analysis,
        Of(
            "drystone.programs.find_forces",
            shown=("form", "virtual"),
            metavars={"virtual": "WHAT[@BLOCKS]"},
        ),
    ],
    wanted: Written,
    waiting: Waiting,
) -> Told:
    """Forces in the joints, with tension where compression is not enough.

    Whether a model stands is asked of check: equilibrium alone is necessary, not sufficient. Exit
    code 0: compression is enough. 1: tension, or more friction than --threshold, is needed.
    """
    model = subject.prepared(waiting)
    wanted.require_through(model.assembly)
    found: Forces = asked.of(waiting, model, doing="solving")

    def files() -> Files:
        pictures, _ = wanted.of(found)
        tables, said = wanted.tables(found.result)
        return [*pictures, *wanted.for_cad(found), *tables], said

    return Told(found, notes=model.notes, files=files)
