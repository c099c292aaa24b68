"""Built-in models: ``models`` lists and writes them, ``demo`` and ``reproduce`` check some."""

from __future__ import annotations

import inspect
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units
from drystone.base.errors import InputError, MissingDependency, counted
from drystone.base.hints import documented
from drystone.cli import families, kinds, offered
from drystone.cli.check_command import safe, solve
from drystone.cli.command import command
from drystone.cli.kinds import output_path
from drystone.cli.offered import OUTPUT, Argument, Option
from drystone.cli.told import Pictures, Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.cli.told import Files
    from drystone.reproduce import Case


_DEMO = "drystone-demo"


@command("drystone models", "drystone models arch --set voussoirs=12 --out arch.json")
def models(
    *,
    family: Annotated[
        str | None, Argument("FAMILY", "A parametric family; all are listed when left out.")
    ] = None,
    set: families.Settings = (),
    out: Annotated[
        Path | None,
        Option(
            "Write the model; its suffix determines the format.",
            OUTPUT,
            kind=kinds.MODEL_FILE,
        ),
    ] = None,
    waiting: Waiting,
) -> Told:
    """List the parametric models, or build one and write it.

    Their supports are fixed. STL and OBJ files cannot store that: add --supports lowest.
    """
    if family is None:
        if set or out is not None:
            raise InputError("no family is named", where="FAMILY", remedy="see 'drystone models'")
        return Told(_all_families())
    build, known = families.family(family)
    given = dict(families.setting(text, known) for text in set)
    from drystone.io import format_of  # the program starts fast

    waiting.stage("build", f"building {family}")
    assembly = build(**given)
    size = assembly.bounds[:, 1].max(axis=0) - assembly.bounds[:, 0].min(axis=0)
    values = {
        **_told(family.replace("_", "-")),
        "set": given,
        "blocks": len(assembly),
        "fixed": int(assembly.fixed.sum()),
        "mass": float(assembly.mass.sum()),
        "size": size.tolist(),
        "loses": "" if out is None else format_of(out, writing=True).loses,
    }

    def files() -> Files:
        from drystone import io  # the program starts fast

        return ([(out, partial(io.write, assembly))] if out is not None else []), []

    return Told(_one_family(values, documented(build)), subject=values["family"], files=files)


def _told(name: str) -> dict[str, Any]:
    """Name, summary and parameters of a family, with their defaults."""
    build, known = families.family(name)
    summary = (inspect.getdoc(build) or "").partition("\n")[0].replace("``", "")
    return {
        "family": name,
        "summary": summary,
        "parameters": {name: one.default for name, one in known.items()},
    }


def _all_families() -> Answer:
    from drystone.answer import Role, Sentence, Statement
    from drystone.base.table import Table

    rows = [_told(name) for name in families.names()]
    columns = {"name": [row["family"] for row in rows], "": [row["summary"] for row in rows]}
    told = (
        Sentence(f"{len(rows)} families", Role.GOOD),
        Sentence("'drystone models FAMILY' lists its parameters, --out FILE writes it"),
    )
    return Statement(told, (Table("names", columns),), {"families": rows})


def _one_family(values: dict[str, Any], told_of: dict[str, dict[str, Any]]) -> Answer:
    from drystone.answer import Role, Sentence, Statement
    from drystone.base.table import Table

    told = [
        Sentence(values["summary"], Role.GOOD),
        Sentence(
            f"{counted(values['blocks'], 'block')}, {values['fixed']} of them fixed, "
            f"{units.extent(values['size'])}, {units.mass(values['mass'])}"
        ),
    ]
    if values["loses"]:
        told.append(Sentence(f"this format does not store {values['loses']}", Role.REMARK))
    chosen = {**values["parameters"], **values["set"]}
    left = {name: one["text"].partition(";")[0] for name, one in told_of.items()}
    shown = [left[name] if value is None else str(value) for name, value in chosen.items()]
    table = Table("its parameters", {"parameter": list(chosen), "value": shown})
    return Statement(tuple(told), (table,), values)


@command("drystone demo", "drystone demo --friction 0.3 --folder .")
def demo(
    *,
    friction: offered.Friction = None,
    folder: Annotated[
        Path, Option("Folder for the model, the page and the figure.", OUTPUT, kind=kinds.FOLDER)
    ] = Path(),
    waiting: Waiting,
) -> Told:
    """Check a built-in vault, and write its model, a page and a figure.

    The files are drystone-demo.json, drystone-demo.html and drystone-demo.png.
    """
    model_path, page, figure = (
        output_path(str(folder / f"{_DEMO}{suffix}"), (suffix,))
        for suffix in (".json", ".html", ".png")
    )
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.model import Model
    from drystone.models import vault

    waiting.stage("read", "building the vault")
    assembly = vault()
    waiting.stage("detect", "finding contacts")
    model = Model.of(assembly, friction=friction)
    result = safe(solve(model, waiting, None), waiting)

    def files() -> Files:
        return [(model_path, partial(io.write, model)), *Pictures(page, figure).of(result)[0]], []

    return Told(result, subject="built-in vault", notes=result.model.notes, files=files)


@command("drystone reproduce 5.1.1", "drystone reproduce 5.1.1 --out .")
def reproduce(
    *,
    section: Annotated[
        str | None,
        Argument(
            "SECTION", "Section of Kao 2023, such as 7.2.4, 7.2 or all; lists them when left out."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        Option(
            "Folder for the pages and figures, made where there is none; none without it.",
            OUTPUT,
            kind=kinds.FOLDER,
        ),
    ] = None,
    waiting: Waiting,
) -> Told:
    """Compute the case studies of the source, and compare with the published figures.

    Exit code 0: all figures that can be compared agree. 1: some differ. 2: bad input.
    """
    from drystone import reproduce as cases  # the program starts fast
    from drystone.answer import Role, Sentence, Statement
    from drystone.reproduce.published_case import agreement

    if section is None:
        if out is not None:
            raise InputError("no section is named", remedy="write a section or all before --out")
        return Told(cases.sections(), subject="sections of Kao 2023", everything=True)
    names = cases.sections_of(section)
    found: list[Case] = []
    written: list[str] = []
    left: list[Sentence] = []
    for name in names:
        waiting.stage("solve", f"section {name}")
        try:
            found.append(cases.reproduce(name))
        except MissingDependency as error:
            if len(names) == 1:
                raise
            left.append(Sentence(f"section {name} is left out: {error}", Role.REMARK))
            continue
        written += [] if out is None else cases.save_case(found[-1], out)
        waiting.wrote = written
    wrong = [case.section for case in found if not case.agrees]
    told = [Sentence(agreement(found), Role.BAD if wrong else Role.GOOD)]
    told += [one for case in found for one in case.sentences()[1:]]
    numbers = {"sections": [case.numbers() for case in found]}
    answer = Statement(
        (*told, *left), tuple(one for case in found for one in case.tables()), numbers
    )
    asked = "all sections" if section == "all" else f"section {section}"
    return Told(answer, subject=asked, written=written, everything=True)
