"""Four shells at three sizes."""

from collections.abc import Mapping

from drystone.shells import (
    Layout,
    Shape,
    Shell,
    ShellBody,
    barrel_vault,
    build_shell,
    dome,
    find_form,
    rectangular_plan,
    three_legged_plan,
)

SAMPLES: Mapping[str, Mapping[int, tuple[Layout, float]]] = {
    "barrel": {
        40: (Layout(courses=9, blocks=4, wedge=0.2), 0.3),
        400: (Layout(courses=27, blocks=15, wedge=0.2), 0.3),
        4000: (Layout(courses=85, blocks=47, wedge=0.2), 0.2),
    },
    "dome": {
        40: (Layout(courses=4, blocks=10, wedge=0.2), 0.4),
        400: (Layout(courses=16, blocks=25, wedge=0.2), 0.4),
        4000: (Layout(courses=50, blocks=80, wedge=0.2), 0.4),
    },
    "freeform": {
        40: (Layout(courses=5, width=1.3, wedge=-0.1), 0.2),
        400: (Layout(courses=16, width=0.35, wedge=-0.1), 0.2),
        4000: (Layout(courses=50, width=0.11, wedge=-0.1), 0.1),
    },
    "form-found": {
        40: (Layout(courses=6, width=1.0, wedge=0.2), 0.2),
        400: (Layout(courses=16, width=0.3, wedge=0.2), 0.2),
        4000: (Layout(courses=60, width=0.108, wedge=0.2), 0.1),
    },
}
"""Per kind and approximate number of voussoirs the layout and the thickness [m]."""


def _sample_shape(kind: str, thickness: float) -> Shape:
    """The middle surface of a sample."""
    if kind == "barrel":
        return barrel_vault(span=6.0, length=6.0, rise=1.732)
    if kind == "dome":
        return dome(radius=5.0, oculus=1.0)
    if kind == "freeform":
        return find_form(three_legged_plan(), height=2.5, thickness=thickness).shape
    return find_form(rectangular_plan(6.0, 5.0), height=1.8, thickness=thickness).shape


def sample_shell(kind: str, size: int = 40) -> Shell:
    """A ``barrel``, ``dome`` with an eye, ``freeform`` of three vaults, or ``form-found``.

    ``size`` is about the number of voussoirs: 40, 400 or 4000.
    """
    layout, thickness = SAMPLES[kind][size]
    shape = _sample_shape(kind, thickness)
    return build_shell(shape, layout, ShellBody(thickness=thickness))
