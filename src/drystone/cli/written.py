"""The files of an answer: the page, the figure, the tables of joints."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.errors import InputError
from drystone.base.files import same_place, write_text
from drystone.cli import kinds, options
from drystone.cli.offered import OUTPUT, Option

if TYPE_CHECKING:
    from drystone.answer import Answer
    from drystone.assembly import Assembly
    from drystone.base.files import Job
    from drystone.cli.told import Files
    from drystone.results import Result
    from drystone.settlement import LargeDisplacement
    from drystone.view import Scene


@dataclass(frozen=True)
class Pictures:
    """The page and the figure."""

    html: options.Html = None
    png: options.Png = None
    section: options.Section = None

    def __post_init__(self) -> None:
        apart([self.html, self.png])
        self.require_picture()

    def require_picture(self) -> None:
        """Refuse a section without a picture.

        Raises
        ------
        InputError
        """
        if self.section is not None and self.html is None and self.png is None:
            raise InputError(
                "has no picture to cut", where="--section", remedy="add --html or --png"
            )

    def require_through(self, assembly: Assembly) -> None:
        """Refuse a section beside the model, before any work.

        Raises
        ------
        InputError
        """
        if self.section is not None:
            from drystone.view.section import section_through  # as below

            section_through(assembly, self.section)

    def cut(self, scene: Scene) -> Scene:
        """A scene with the section that is asked for."""
        from drystone.view.section import cut_at  # pictures are imported when asked for

        return scene if self.section is None else cut_at(scene, self.section)

    def jobs(self, page: Callable[[Path], object], figure: Callable[[Path], object]) -> list[Job]:
        """The files to write, from the functions that write them."""
        both = ((self.html, page), (self.png, figure))
        return [(path, write) for path, write in both if path is not None]

    def of(self, subject: Answer) -> Files:
        """The pictures of an answer."""
        if self.html is None and self.png is None:
            return [], []
        from drystone import view  # the program starts fast: pictures are imported when asked for

        page = partial(view.save_page, subject, section=self.section)
        figure = partial(view.save_figure, subject, section=self.section)
        return self.jobs(page, figure), []


@dataclass(frozen=True)
class Curves(Pictures):
    """The page, the plot and the curve as numbers."""

    curve: Annotated[
        Path | None,
        Option(
            "Write the curve of load against displacement, .csv or .json.",
            OUTPUT,
            kind=kinds.target(".csv", ".json"),
        ),
    ] = None

    def __post_init__(self) -> None:
        apart([self.html, self.png, self.curve])
        self.require_picture()

    def with_curve(self, subject: LargeDisplacement) -> Files:
        """The pictures of an answer, and its curve."""
        jobs, said = self.of(subject)
        if self.curve is None:
            return jobs, said
        if self.curve.suffix.lower() == ".csv":
            return [*jobs, (self.curve, subject.table().to_csv)], said
        from drystone.base.files import write_bytes  # work is imported when there is some

        data = json.dumps(subject.to_dict()).encode("utf-8")
        return [*jobs, (self.curve, partial(write_bytes, data=data))], said


@dataclass(frozen=True)
class Written(Pictures):
    """The page, the figure, the file for CAD programs and the tables of joints."""

    cad: options.Cad = None
    joints: Annotated[
        tuple[Path, ...],
        Option(
            "Write a table of all joints, .csv or .json, or a page on the worst, .html. Can be "
            "given several times.",
            OUTPUT,
            kind=kinds.target(".csv", ".json", ".html"),
        ),
    ] = ()
    strength: Annotated[
        float | None,
        Option(
            "Pressure in MPa that the stone bears; joints above it are marked.",
            OUTPUT,
            kind=kinds.POSITIVE,
            expert=True,
        ),
    ] = None

    def __post_init__(self) -> None:
        apart([self.html, self.png, self.cad, *self.joints])
        self.require_picture()
        refuse_missing(self.cad)

    def all_of(self, result: Result) -> Files:
        """The pictures and the tables of a result, and remarks."""
        jobs, _ = self.of(result)
        more, said = self.tables(result)
        return [*jobs, *self.for_cad(result), *more], said

    def for_cad(self, subject: Answer) -> list[Job]:
        """The file for CAD programs, where one is asked for."""
        return cad_jobs(self.cad, subject)

    def tables(self, result: Result) -> Files:
        """The tables of joints, and remarks."""
        if result.force is None:
            return [], ["no joint table: there are no forces"] if self.joints else []
        if not self.joints and self.strength is None:
            return [], []
        from drystone.view import save_report

        strength = None if self.strength is None else 1e6 * self.strength
        table = result.joints(strength=strength)
        jobs: list[Job] = []
        for path in self.joints:
            if path.suffix.lower() == ".html":
                jobs.append((path, partial(save_report, result, strength=strength)))
            elif path.suffix.lower() == ".csv":
                jobs.append((path, table.to_csv))
            else:
                content = json.dumps({"strength": strength, **table.to_dict()})
                jobs.append((path, partial(write_text, text=content)))
        if strength is None:
            return jobs, []
        over = int(table["over_strength"].sum())
        return jobs, [
            f"the peak pressure exceeds {self.strength:g} MPa at {over} of {len(table)} joints"
        ]


def refuse_missing(cad: Path | None) -> None:
    """Refuse a file for CAD programs before any work if its package is missing.

    Raises
    ------
    MissingDependency
    """
    if cad is not None and cad.suffix.lower() == ".3dm":
        from drystone.io.rhino import require

        require("writing 3dm")


def cad_jobs(path: Path | None, subject: Answer) -> list[Job]:
    """The file for CAD programs, where one is asked for."""
    if path is None:
        return []
    from drystone.view import save_cad  # as above

    return [(path, partial(save_cad, subject))]


def apart(paths: Sequence[Path | None]) -> None:
    """Refuse two outputs with one file name.

    Raises
    ------
    InputError
    """
    seen: set[str] = set()
    for path in paths:
        if path is not None and same_place(path) in seen:
            raise InputError("is named twice", where=f"'{path}'", remedy="name each file once")
        if path is not None:
            seen.add(same_place(path))
