"""The answer of every command: text, JSON, files and an exit code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from drystone.base.errors import DrystoneError
from drystone.base.files import Job, write_together
from drystone.cli.base import output
from drystone.cli.base.output import Screen
from drystone.cli.base.waiting import NOTHING, Waiting

Files: TypeAlias = tuple[list[Job], list[str]]
"""Files to be written all together, and remarks on them."""


@dataclass(frozen=True)
class Answer:
    """The answer of a command, before its files are written and it is printed.

    Attributes
    ----------
    data
        Plain values, as ``--json`` prints them; notes, files and times are added.
    show
        Prints it for people.
    code
        Exit code.
    notes
        Remarks.
    files
        Makes the files. It is called when the answer is known, so that the answer survives Ctrl-C
        and a full disk.
    written
        Names of files that are written already.
    """

    data: dict[str, Any]
    show: Callable[[Screen], None]
    code: int = 0
    notes: Sequence[str] = ()
    files: Callable[[], Files] | None = None
    written: Sequence[str] = ()


def finish(answer: Answer, waiting: Waiting, as_json: bool) -> Callable[[], int]:
    """Write the files of an answer; the returned function prints it and gives the exit code."""
    notes, files, failed = list(answer.notes), list(answer.written), None
    if answer.files is not None:
        waiting.stage("write", "writing")
        try:
            jobs, said = answer.files()
            files += write_together(jobs)
            notes += said
        except KeyboardInterrupt:
            waiting.interrupted = True
            notes.append(f"interrupted: {NOTHING}")
        except (DrystoneError, OSError) as error:
            failed = error
    waiting.wrote = files
    data = {**answer.data, "notes": notes, "files": files}

    def tell() -> int:
        spent = {key: s for key, s in waiting.time_s.items() if key != "write" or files}
        data.setdefault("time_s", spent)
        if failed is not None and as_json:
            return output.fail(failed, output.code_of(failed), as_json, data)
        if as_json:
            output.emit(data)
        else:
            screen = Screen()
            answer.show(screen)
            for note in notes:
                screen.note(note)
            screen.dim(", ".join(f"{key} {value:.2f} s" for key, value in data["time_s"].items()))
            for name in files:
                screen.line(f"wrote {name}")
        if failed is not None:
            return output.fail(failed, output.code_of(failed), as_json)
        return waiting.exit_code(answer.code)

    return tell
