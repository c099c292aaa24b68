"""The source's own structures, computed again: published beside found, one function per section.

Source: Kao 2023, doctoral dissertation, ETH Zurich; Kao et al. 2022, Computer-Aided Design 146.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from drystone.base.errors import InputError
from drystone.base.files import PathLike
from drystone.reproduce import cases
from drystone.reproduce.published_case import Case, Line

SECTIONS: dict[str, Callable[[], Case]] = {
    "6.1": cases.arches,
    "6.1.2": cases.buttressed_arch,
    "6.1.3": cases.dome,
    "6.2": cases.pinched_blocks,
    "6.3": cases.shelf,
    "6.4.2": cases.two_robots,
    "7.2": cases.snake,
    "7.2.4": cases.bridge,
    "7.5": cases.shells,
}
"""Sections, and what computes each."""


def reproduce(section: str) -> Case:
    """Compute a section of the source again.

    Raises
    ------
    InputError
        There is no such section.

    Examples
    --------
    >>> case = reproduce("6.2")
    >>> [line.found for line in case.lines]
    ['stable / unstable', 'stable / unstable']
    """
    if section not in SECTIONS:
        raise InputError(
            f"there is no section '{section}'",
            where="section",
            remedy=f"give one of {', '.join(SECTIONS)}",
        )
    return SECTIONS[section]()


def save_case(case: Case, folder: PathLike) -> list[str]:
    """Write the pages and figures of a case into a folder that exists.

    Parameters
    ----------
    case
    folder
        Files are named after the section and the model.

    Returns
    -------
    list of str
        The files that were written.
    """
    from drystone.sequence import Plan
    from drystone.view import save_figure, save_page

    target = Path(folder)
    if not target.is_dir():
        raise InputError("there is no such folder", where=str(target), remedy="make it first")
    written = []
    for name, subject in case.pictures.items():
        if isinstance(subject, Plan) and not subject.steps:
            continue
        page, figure = (target / f"{case.section}-{name}{suffix}" for suffix in (".html", ".png"))
        save_page(subject, page)
        save_figure(subject, figure)
        written += [str(page), str(figure)]
    return written


__all__ = ["SECTIONS", "Case", "Line", "reproduce", "save_case"]
