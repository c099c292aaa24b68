"""Four shells at any of three sizes: for the documentation, the tests and the benchmarks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from drystone.base.errors import InputError
from drystone.base.progress import Progress
from drystone.shells.shell_of_blocks import Shell, build_shell
from drystone.shells.shell_options import Layout, ShellBody
from drystone.shells.surface.formfinding import find_form
from drystone.shells.surface.shape import Shape
from drystone.shells.surface.shell_families import (
    barrel_vault,
    dome,
    rectangular_plan,
    three_legged_plan,
)


@dataclass(frozen=True)
class Sample:
    """One size of a sample: its layout and thickness [m]."""

    layout: Layout
    thickness: float


SAMPLES: Mapping[str, Mapping[int, Sample]] = MappingProxyType(
    {
        "barrel": {
            40: Sample(Layout(courses=9, blocks=4, wedge=0.2), 0.3),
            400: Sample(Layout(courses=27, blocks=15, wedge=0.2), 0.3),
            4000: Sample(Layout(courses=85, blocks=47, wedge=0.2), 0.2),
        },
        "dome": {
            40: Sample(Layout(courses=4, blocks=10, wedge=0.2), 0.4),
            400: Sample(Layout(courses=16, blocks=25, wedge=0.2), 0.4),
            4000: Sample(Layout(courses=50, blocks=80, wedge=0.2), 0.4),
        },
        "freeform": {
            40: Sample(Layout(courses=5, width=1.3, wedge=-0.1), 0.2),
            400: Sample(Layout(courses=16, width=0.35, wedge=-0.1), 0.2),
            4000: Sample(Layout(courses=50, width=0.11, wedge=-0.1), 0.1),
        },
        "form-found": {
            40: Sample(Layout(courses=6, width=1.0, wedge=0.2), 0.2),
            400: Sample(Layout(courses=16, width=0.3, wedge=0.2), 0.2),
            4000: Sample(Layout(courses=60, width=0.108, wedge=0.2), 0.1),
        },
    }
)
"""Kinds, and the approximate number of voussoirs of each size."""


def sample_shape(kind: str, thickness: float) -> Shape:
    """The middle surface of a sample."""
    if kind == "barrel":
        return barrel_vault(span=6.0, length=6.0, rise=1.732)
    if kind == "dome":
        return dome(radius=5.0, oculus=1.0)
    if kind == "freeform":
        return find_form(three_legged_plan(), height=2.5, thickness=thickness).shape
    return find_form(rectangular_plan(6.0, 5.0), height=1.8, thickness=thickness).shape


def sample_shell(kind: str, size: int = 40, *, progress: Progress | None = None) -> Shell:
    """A sample: ``barrel``, ``dome`` with an eye, ``freeform`` of three vaults, or ``form-found``.

    Parameters
    ----------
    kind
    size
        40, 400 or 4000, about the number of voussoirs.
    progress

    Raises
    ------
    InputError
        Another kind or size.

    Examples
    --------
    >>> from drystone.shells import sample_shell
    >>> len(sample_shell("dome").voussoirs)
    40
    """
    if kind not in SAMPLES or size not in SAMPLES[kind]:
        raise InputError(
            f"there is no sample '{kind}' of {size} blocks",
            remedy=f"kinds are {', '.join(SAMPLES)}; sizes 40, 400, 4000",
        )
    sample = SAMPLES[kind][size]
    shape = sample_shape(kind, sample.thickness)
    return build_shell(
        shape, sample.layout, ShellBody(thickness=sample.thickness), progress=progress
    )
