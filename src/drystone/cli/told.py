"""The answer of every command: text, JSON, files and an exit code."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from drystone.base.errors import DrystoneError, FormatError
from drystone.base.files import Job, write_together
from drystone.cli import output
from drystone.cli.output import LISTED, Screen, grouped
from drystone.cli.waiting import NOTHING, Waiting

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.base.table import Table

Files: TypeAlias = tuple[list[Job], list[str]]
"""Files to be written all together, and remarks on them."""


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
    if everything or not isinstance(next(iter(table.columns.values()))[0], str):
        screen.table(heads, rows, len(rows) if everything else LISTED)
        return
    shown = grouped(rows)
    screen.table(heads, shown)
    if len(shown) < len(rows):
        screen.dim("equal rows share a line (--json lists all)")


def finish(answer: Told, waiting: Waiting, as_json: bool) -> Callable[[], int]:
    """Write the files of an answer; the returned function prints it and gives the exit code."""
    notes, files, failed = list(answer.notes), list(answer.written), None
    if answer.files is not None:
        waiting.stage("write", "writing")
        try:
            jobs, said = answer.files()
            files += write_together(jobs, into=answer.into)
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
