"""The source's own structures, computed again: published beside found, one function per section.

Source: Kao 2023, doctoral dissertation, ETH Zurich; Kao et al. 2022, Computer-Aided Design 146.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from pathlib import Path

from drystone.answer import Role, Sentence, Statement
from drystone.base.errors import InputError
from drystone.base.files import Job, PathLike, write_together
from drystone.base.settings import hold
from drystone.base.table import Table
from drystone.reproduce import assembly_cases, equilibrium_cases, tilt_cases
from drystone.reproduce.published_case import Case, Line

SECTIONS: dict[str, Callable[[], Case]] = {
    "4.2": assembly_cases.equilibrium,
    "4.3": assembly_cases.kerns,
    "4.4": assembly_cases.resultants,
    "4.5": assembly_cases.assembly_graph,
    "5.1.1": equilibrium_cases.pinched_blocks,
    "5.1.2": equilibrium_cases.wedged_block,
    "5.3": equilibrium_cases.penalty_form,
    "6.1.1": equilibrium_cases.stack,
    "6.1.2": equilibrium_cases.buttressed_arch,
    "6.1.3": equilibrium_cases.dome,
    "6.2.1": tilt_cases.arches,
    "6.2.2": equilibrium_cases.shelf,
    "6.2.3": tilt_cases.wedges,
    "6.2.4": tilt_cases.concave,
    "6.2.5": tilt_cases.curved,
    "6.3.2": assembly_cases.shelf_fixes,
    "6.3.3": assembly_cases.wedge_arch,
    "6.4.2": assembly_cases.two_robots,
    "7.2.1": assembly_cases.leaning_tower,
    "7.2.3": assembly_cases.snake,
    "7.2.4": assembly_cases.bridge,
    "7.5.1": assembly_cases.vault,
    "7.5.2": assembly_cases.dome,
    "7.5.3": assembly_cases.freeform,
    "8.4": assembly_cases.example,
    "8.5": assembly_cases.performance,
}
"""Sections, and what computes each."""


def reproduce(section: str) -> Case:
    """Compute a section of the source again.

    Parameters
    ----------
    section
        Its number, such as ``5.1.1``.

    Raises
    ------
    InputError
        There is no such section.

    Examples
    --------
    >>> case = reproduce("5.1.1")
    >>> [line.found for line in case.lines]
    ['stable / unstable', 'stable / unstable']
    """
    if section not in SECTIONS:
        sections_of(section)
        raise InputError(f"'{section}' has several sections", where="section", remedy="give one")
    return SECTIONS[section]()


def sections_of(part: str) -> list[str]:
    """The sections of a part of the source: one such as 7.2.4, a chapter, or all.

    Parameters
    ----------
    part
        Number of a section or chapter, such as ``7.5``; ``all`` for all.

    Raises
    ------
    InputError
        There is none that is computed.

    Examples
    --------
    >>> sections_of("7.5")
    ['7.5.1', '7.5.2', '7.5.3']
    """
    found = [one for one in SECTIONS if part in ("all", one) or one.startswith(f"{part}.")]
    if not found:
        raise InputError(
            f"there is no section '{part}' that is computed",
            where="section",
            remedy=f"give one of {', '.join(SECTIONS)}; "
            "for others see docs/trust/source-studies.md",
        )
    return found


def sections() -> Statement:
    """The sections that are computed, and what of each.

    Examples
    --------
    >>> str(sections().tables()[0]["section"][0])
    '4.2'
    """
    about = [(inspect.getdoc(one) or "").splitlines()[0] for one in SECTIONS.values()]
    table = Table("sections", {"section": list(SECTIONS), "about": about})
    told = "Sections of Kao 2023 that are computed, such as: drystone reproduce 5.1.1"
    return Statement((Sentence(told, Role.GOOD),), (table,))


def save_case(case: Case, folder: PathLike) -> list[str]:
    """Write the pages and figures of a case into a folder, which is made where there is none.

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
    jobs: list[Job] = []
    for name, subject in case.pictures.items():
        if isinstance(subject, Plan) and not subject.steps:
            continue
        page, figure = (target / f"{case.section}-{name}{suffix}" for suffix in (".html", ".png"))
        jobs += [(page, partial(save_page, subject)), (figure, partial(save_figure, subject))]
    return write_together(jobs, into=target)


__all__ = ["SECTIONS", "Case", "Line", "reproduce", "save_case", "sections", "sections_of"]

hold(globals())
