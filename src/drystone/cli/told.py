"""The answer of every command: text, JSON, files and an exit code.

The files of an answer: the page, the figure, the file for CAD programs, tables, the model.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.base.errors import DrystoneError, FormatError, InputError, require
from drystone.base.files import same_place, write_text, write_together
from drystone.cli import kinds, offered, output
from drystone.cli.offered import OUTPUT, Option, writes
from drystone.cli.output import LISTED, Screen, grouped
from drystone.cli.waiting import NOTHING, Waiting

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.assembly import Assembly
    from drystone.base.table import Table
    from drystone.io.draft import Contents
    from drystone.io.registry import Format
    from drystone.report import TitleBlock
    from drystone.results import Result


Jobs: TypeAlias = list[tuple[Path | None, Callable[[Path], object]]]
Files: TypeAlias = tuple[Jobs, list[str]]
"""Files to be written all together but for those without a path, and remarks on them."""

STYLE = {
    "good": "bold green",
    "bad": "bold red",
    "unsure": "bold yellow",
    "plain": "default",
    "remark": "yellow",
}
"""Of a sentence by its role."""


@dataclass(frozen=True)
class Told:
    """The answer of an analysis, and what a command adds to it.

    Attributes
    ----------
    answer
    also
        Further answers, by their key in the JSON.
    subject
        What was asked about, where that is no file.
    exit_code
        That of the answer when left out.
    notes
        Remarks.
    files
        Makes the files. It is called when the answer is known, so that the answer survives Ctrl-C
        and a full disk.
    into
        A folder that is made for the files where there is none.
    written
        Names of files that are written already.
    everything
        Print every row of the tables.
    then
        The command that follows.
    """

    answer: Answer
    also: Mapping[str, Answer] = field(default_factory=dict)
    subject: str = ""
    exit_code: int | None = None
    notes: Sequence[str] = ()
    files: Callable[[], Files] | None = None
    into: Path | None = None
    written: Sequence[str] = ()
    everything: bool = False
    then: str = ""

    @property
    def code(self) -> int:
        """The exit code."""
        return self.answer.code if self.exit_code is None else self.exit_code

    @property
    def data(self) -> dict[str, Any]:
        """Plain values, as ``--json`` prints them."""
        also = {key: one.to_dict() for key, one in self.also.items()}
        return {"model": self._subject, **self.answer.to_dict(), **also}

    @property
    def _subject(self) -> str:
        return self.subject or self.answer.asked.file

    def show(self, screen: Screen) -> None:
        """Print it for people, the worst of all answers first."""
        from drystone.answer import worst_first  # the program starts without numpy

        told = {sentence.text for sentence in self.answer.sentences()}
        worst = worst_first([self.answer, *self.also.values()])[0]
        if worst is not self.answer:
            bad = worst.sentences()[0]
            screen.line("", bad.text, STYLE[worst.news.value])
            told.add(bad.text)
        _show(screen, self.answer, self._subject, self.everything)
        for one in self.also.values():
            for sentence in one.sentences():
                if sentence.text not in told:
                    screen.line(sentence.text)
        screen.dim(self.answer.asked.line())


_ASKED = 4
"""Rows of what was asked that are printed, as of loads. Chosen: of fill there is one a block."""


def _show(screen: Screen, answer: Answer, subject: str, everything: bool) -> None:
    """Its sentences, the first one with what was asked about, and its tables."""
    first, *others = answer.sentences()
    screen.line(subject, first.text, STYLE[first.role.value])
    for one in others:
        screen.line(
            one.text, "note:" if one.role.value == "remark" else "", STYLE[one.role.value], " "
        )
    for table in filter(len, answer.tables()):
        screen.line(f"{table.title.replace('_', ' ')}:")
        show_table(screen, table, everything)


def show_table(screen: Screen, table: Table, everything: bool = False) -> None:
    """The first rows of a table, those that are equal but for a name on one line; or all."""
    heads, rows = table.cells()
    listed = _ASKED if table.asked else LISTED
    if everything or not isinstance(next(iter(table.columns.values()))[0], str):
        screen.table(heads, rows, len(rows) if everything else listed)
        return
    shown = grouped(rows)
    screen.table(heads, shown, listed)
    if len(shown) < len(rows):
        screen.dim("equal rows share a line (--json lists all)")


def finish(answer: Told, waiting: Waiting, as_json: bool) -> Callable[[], int]:
    """Write the files of an answer; the returned function prints it and gives the exit code."""
    notes, files, failed = list(answer.notes), list(answer.written), None
    if answer.files is not None:
        waiting.stage("write", "writing")
        try:
            jobs, said = answer.files()
            asked = [(path, write) for path, write in jobs if path is not None]
            files += write_together(asked, into=answer.into)
            notes += said
        except KeyboardInterrupt:
            waiting.interrupted = True
            notes.append(f"interrupted: {NOTHING}")
        except (DrystoneError, OSError) as error:
            if waiting.interrupted and not isinstance(error, FormatError | OSError):
                notes.append(f"interrupted: {NOTHING}: {error}")  # of half an answer
            else:
                failed = error
    waiting.wrote = files
    then = {"next": answer.then} if answer.then else {}
    data = {**answer.data, **then, "notes": notes, "files": files}

    def tell() -> int:
        spent = {key: s for key, s in waiting.time_s.items() if key != "write" or files}
        data["time_s"] = {**data.get("time_s", {}), **spent}
        if failed is not None and as_json:
            return output.fail(failed, output.code_of(failed), as_json, data)
        if as_json:
            output.emit(data)
        else:
            screen = Screen()
            answer.show(screen)
            told = {sentence.text for sentence in answer.answer.sentences()}
            for note in notes:
                if note not in told:
                    screen.note(note)
            screen.dim(", ".join(f"{key} {value:.2f} s" for key, value in data["time_s"].items()))
            for name in files:
                screen.line(f"wrote {name}")
            if answer.then:
                screen.line(f"next: {answer.then}")
        if failed is not None:
            return output.fail(failed, output.code_of(failed), as_json)
        return waiting.exit_code(answer.code)

    return tell


@dataclass(frozen=True)
class Pictures:
    """The page, the figure, the file for CAD programs and the table: every answer has them."""

    html: offered.Html = None
    png: offered.Png = None
    section: offered.Section = None
    cad: offered.RareCad = None
    csv: offered.Csv = None
    report: offered.RareReport = None
    title_block: offered.RareTitleBlock = None

    def __post_init__(self) -> None:
        every = [getattr(self, one.name) for one in fields(self)]
        apart([path for one in every for path in (one if isinstance(one, tuple) else (one,))])
        if self.section is not None and self.html is None and self.png is None:
            raise InputError(
                "has no picture to cut", where="--section", remedy="add --html or --png"
            )
        if self.title_block is not None:
            if self.report is None:
                what, remedy = "is for a calculation report", "add --report sheet.pdf"
                raise InputError(what, where="--title-block", remedy=remedy)
            _ = self._about  # before any work
        if self.report is not None and self.report.suffix.lower() == ".pdf":
            from drystone.report import require_pdf

            require_pdf()
        if self.cad is not None and self.cad.suffix.lower() == ".3dm":
            require("rhino3dm", "cad", "writing 3dm")  # before any work

    @cached_property
    def _about(self) -> TitleBlock | None:
        from drystone.report import TitleBlock  # reports are imported when needed

        return None if self.title_block is None else TitleBlock.read(self.title_block)

    def require_through(self, assembly: Assembly) -> None:
        """Refuse a section beside the model, before any work.

        Raises
        ------
        InputError
        """
        if self.section is not None:
            from drystone.view.section import section_through  # pictures are imported when needed

            section_through(assembly, self.section)

    def of(self, answer: Any) -> Files:
        """The files of an answer, and remarks on them."""
        jobs: Jobs = []
        if self.html is not None or self.png is not None or self.cad is not None:
            from drystone import view  # as above

            section = self.section
            jobs += [
                (self.html, partial(view.save_page, answer, section=section)),
                (self.png, partial(view.save_figure, answer, section=section)),
                (self.cad, partial(view.save_cad, answer)),
            ]
        if self.csv is not None:
            jobs.append((self.csv, answer.table().to_csv))
        if self.report is not None:
            from drystone.report import write_report  # as above

            jobs.append((self.report, partial(write_report, answer, about=self._about)))
        return jobs, []


@dataclass(frozen=True)
class WithFilm(Pictures):
    """The film of an answer with several stages too."""

    film: Annotated[
        Path | None, writes("Write a film of the stages, .gif.", ".gif", expert=True)
    ] = None

    def of(self, answer: Any) -> Files:
        """The pictures and the film of an answer, and remarks on them."""
        jobs, said = super().of(answer)
        if self.film is not None:
            from drystone.view import save_film  # pictures are imported when needed

            jobs.append((self.film, partial(save_film, answer)))
        return jobs, said


@dataclass(frozen=True)
class Written(Pictures):
    """The tables of joints and of their corners too."""

    cad: offered.Cad = None
    joints: Annotated[
        tuple[Path, ...],
        Option(
            "Write a table of all joints, .csv or .json, or a page on the worst, .html. Can be "
            "given several times; --corners FILE has the force at every corner.",
            OUTPUT,
            kind=kinds.target(".csv", ".json", ".html"),
        ),
    ] = ()
    corners: Annotated[
        tuple[Path, ...],
        writes(
            "Write the force at every corner of contact, .csv or .json.",
            ".csv",
            ".json",
            expert=True,
        ),
    ] = ()

    def of(self, answer: Any) -> Files:
        """The files of an answer that is a result or has one, and remarks on them."""
        jobs, said = super().of(answer)
        if not self.joints and not self.corners:
            return jobs, said
        result: Result = getattr(answer, "result", answer)
        if result.force is None:
            return jobs, ["no table of joints or corners: there are no forces"]
        for path in self.joints:
            if path.suffix.lower() == ".html":
                from drystone.report import save_joints

                jobs.append((path, partial(save_joints, result)))
            else:
                jobs.append(_table(path, result.joints()))
        jobs += [_table(path, result.corners()) for path in self.corners]
        return jobs, []


def _table(path: Path, table: Table) -> tuple[Path, Callable[[Path], object]]:
    """A file with a table, .csv or .json."""
    if path.suffix.lower() == ".csv":
        return path, table.to_csv
    return path, partial(write_text, text=json.dumps(table.to_dict()))


@dataclass(frozen=True)
class WithModel(Pictures):
    """The changed model too."""

    out: Annotated[
        Path | None,
        Option(
            "Write the changed or loaded model; the suffix determines the format, as with convert.",
            OUTPUT,
            kind=kinds.MODEL_FILE,
        ),
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.out is not None:
            from drystone.io.registry import writable  # as above

            writable(self.out)  # before any work

    def of(self, answer: Any) -> Files:
        """The changed model, and its pictures with the edges of the model before."""
        jobs, said = super().of(answer)
        if self.out is None:
            return jobs, said
        from drystone import io
        from drystone.io.registry import contents_of

        made = getattr(answer, "loaded", answer.model)
        origin = getattr(getattr(answer, "before", None), "origin", made.origin)
        units = origin.units
        write = partial(io.write, made, units=units)
        chosen = io.format_of(self.out, writing=True)
        said = [*said, *left_out(chosen, units, contents_of(made))]
        if "up" in origin.reading:
            said.append(f"z is up in {self.out.name}")
        return [(self.out, write), *jobs], said


@dataclass(frozen=True)
class WithLoaded(WithFilm, WithModel):
    """The film of a train, and the bridge under it."""


def left_out(chosen: Format, units: str, contents: Contents) -> list[str]:
    """What a format does not store, what of it this model has, and a unit that it does not name."""
    from drystone.supports import laid_ground

    said = [f"this format does not store {chosen.loses}"] if chosen.loses else []
    if chosen.loses and _loses_a_pull(chosen, contents):
        said.append("ties and glue are not in this file, what they hold falls: write .json")
    if (ground := laid_ground(contents.assembly)) is not None:
        name = contents.assembly.names[ground]
        said.append(f"its '{name}' is the plane that supports lay, no block to build")
    if chosen.any_unit and chosen.name != "3dm":
        said.append(f"its lengths are in {units}, which the file does not say: --units {units}")
    return said


def _loses_a_pull(chosen: Format, contents: Contents) -> bool:
    """Whether the model has joints that are strong, or ties, that a format does not store."""
    from drystone.io.registry import kept_ties

    contacts, kept = contents.contacts, () if ", ties," in chosen.loses else kept_ties(contents)
    if contacts is None:
        return len(contents.ties) > len(kept)
    return bool(contacts.ties.sum() > len(kept) or not contacts.plain.all())


def apart(paths: Sequence[Any]) -> None:
    """Refuse two outputs with one file name.

    Raises
    ------
    InputError
    """
    seen: set[str] = set()
    for path in paths:
        if isinstance(path, Path) and same_place(path) in seen:
            raise InputError("is named twice", where=f"'{path}'", remedy="name each file once")
        if isinstance(path, Path):
            seen.add(same_place(path))
