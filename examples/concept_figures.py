"""The figures of docs/concepts/concepts.md.

python examples/concept_figures.py docs/images

Curves and the mechanism are computed by drystone; the others are drawings.
"""

import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from diagrams import arrow, label, svg

import drystone
from drystone.base.files import write_bytes
from drystone.mechanics import law
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions
from drystone.models import arch, box
from drystone.stability.problem import Problem

Points = Iterable[tuple[float, float]]
THIN, THICK = 0.1, 0.15
"""Thickness / radius of the arches that are drawn."""


def path(points: Points, style: str = 'class="b"', closed: bool = True) -> str:
    """Straight lines between points, in whole pixels."""
    told = " L ".join(f"{x:.0f} {y:.0f}" for x, y in points)
    return f'<path d="M {told}{" Z" if closed else ""}" {style}/>'


def curve(points: Points, colour: str, dash: str = "") -> str:
    """A line of a diagram."""
    style = f'fill="none" stroke="{colour}" stroke-width="2.5" stroke-dasharray="{dash}"'
    return path(points, style, closed=False)


def square(left: float, top: float, width: float, height: float, style: str = 'class="b"') -> str:
    """A rectangle."""
    ends = (left + width, top + height)
    return path([(left, top), (ends[0], top), ends, (left, ends[1])], style)


DASHED = 'fill="none" stroke="#6b6459" stroke-dasharray="5 4"'
BLUE, RED, GREY = "#1f5fa8", "#b3261e", "#6b6459"


def walls(left: float) -> list[str]:
    """Two fixed walls, 120 apart."""
    return [square(left, 60, 40, 190), square(left + 160, 60, 40, 190)]


def prestress() -> str:
    """A block between two walls: what equilibrium accepts, and what happens."""
    parts = [label(20, 30, "Equilibrium: forces exist that balance the weight", "t")]
    parts += [*walls(60), square(100, 100, 120, 90)]
    parts += [
        arrow(100, 150, 42, 0), label(112, 168, "N"),
        arrow(220, 150, -42, 0), label(196, 168, "N"),
        arrow(100, 150, 0, -42), label(106, 118, "T"),
        arrow(220, 150, 0, -42), label(205, 118, "T"),
        arrow(160, 160, 0, 62, "r"), label(168, 215, "W"),
        label(20, 280, "2 T = W with T ≤ μ N, for every N ≥ W / (2 μ)."),
        label(20, 302, "Nothing causes this N. It is prestress.", "s"),
    ]  # fmt: skip
    parts += [label(420, 30, "What happens: the block slides down", "t"), *walls(460)]
    parts += [square(500, 100, 120, 90, DASHED), square(500, 140, 120, 90)]
    parts += [
        arrow(560, 195, 0, 62, "r"), label(568, 250, "W"),
        label(420, 280, "Its faces move along the walls, d_n = 0."),
        label(420, 302, "No corner closes, so N = 0 and T = 0.", "s"),
    ]  # fmt: skip
    return svg(760, 320, parts)


def coupled() -> str:
    """The same block moved towards each wall: it never presses both."""
    parts = []
    told = (
        ("It moves left", -14, "left: d_n < 0, presses", "right: d_n > 0, opens"),
        ("It moves right", 14, "left: d_n > 0, opens", "right: d_n < 0, presses"),
        ("It moves down", 0, "left: d_n = 0", "right: d_n = 0"),
    )
    for column, (title, shift, *lines) in enumerate(told):
        left = 30 + 245 * column
        parts += [label(left, 30, title, "t"), *walls(left)]
        down = 16 if shift == 0 else 0
        parts.append(square(left + 40, 100, 120, 90, DASHED))
        parts.append(square(left + 40 + shift, 100 + down, 120, 90, 'class="b" opacity="0.85"'))
        if shift:
            side = left + (40 if shift < 0 else 160)
            parts.append(arrow(side, 145, 46 if shift < 0 else -46, 0))
            parts.append(label(left + (46 if shift < 0 else 74), 168, "force of the wall", "s"))
        parts += [label(left, 276 + 20 * row, line) for row, line in enumerate(lines)]
    return svg(760, 320, parts)


def shares(thickness: float, exponents: Iterable[float]) -> list[tuple[float, float]]:
    """For each ground spring 10^-k, the logarithm of the share of the load that it carries."""
    problem = Problem.build(drystone.Model.of(arch(thickness, 11), friction=0.7))
    uniform, load = law.uniform(problem.statics), problem.statics.load
    found = []
    for k in exponents:
        state = find_rest(problem.statics, uniform, RestOptions(ground=10.0**-k))
        carried = law.wrench_size(state.ground).sum() / law.wrench_size(load).sum()
        found.append((k, math.log10(carried)))
    return found


def coloured(colour: str, x: float, y: float, text: str) -> str:
    """A line of text in a colour."""
    return label(x, y, text).replace("<text", f'<text style="fill:{colour}"')


def axes(left: float, top: float, width: float, height: float, x: str, y: str) -> list[str]:
    """Two axes that meet at the lower left, with their names."""
    bottom = top + height
    return [
        curve([(left, top), (left, bottom), (left + width, bottom)], GREY),
        label(left + width / 2, bottom + 40, x, "s", "middle"),
        label(left, top - 10, y, "s"),
    ]


def springs() -> str:
    """The two laws of eq. 6, and the share of the ground springs of two arches (computed)."""
    parts = [label(20, 25, "Normal: only pushes", "t")]
    parts += [
        curve([(20, 200), (210, 200)], GREY), curve([(120, 60), (120, 240)], GREY),
        label(210, 218, "d_n", "s", "end"), label(127, 72, "f_n", "s"),
        curve([(30, 80), (120, 200), (205, 200)], BLUE),
        label(30, 260, "closed", "s"), label(150, 260, "open", "s"), label(42, 140, "k_n", "s"),
        label(250, 25, "Tangential: sticks, slides", "t"),
        curve([(250, 150), (440, 150)], GREY), curve([(345, 60), (345, 240)], GREY),
        label(440, 168, "d_t", "s", "end"), label(352, 72, "−f_t", "s"),
        curve([(255, 220), (305, 220), (385, 80), (435, 80)], BLUE),
        label(390, 72, "μ f_n", "s"), label(372, 130, "k_t", "s"),
    ]  # fmt: skip
    left, top, width, height = 545, 60, 190, 180
    parts.append(label(490, 25, "What the ground springs carry", "t"))
    parts += axes(
        left, top, width, height, "stiffness g of the ground springs", "share of the load"
    )
    for k in (0, 2, 4, 6, 8):
        told = f"1e-{k}" if k else "1"
        parts.append(label(left + width * k / 8, top + height + 18, told, "s", "middle"))
    for power in (0, -2, -4, -6):
        at = top + height * -power / 7.0
        parts.append(label(left - 6, at + 5, f"1e{power}" if power else "1", "s", "end"))
    for thickness, colour, word, at in ((THICK, BLUE, "stands", 215), (THIN, RED, "falls", 100)):
        line = shares(thickness, range(9))
        points = [(left + width * k / 8, top + height * -s / 7.0) for k, s in line]
        parts += [curve(points, colour), coloured(colour, left + 96, at, word)]
    parts.append(
        label(20, 305, "Right: arches of 11 voussoirs, thickness / radius 0.15, 0.10.", "s")
    )
    return svg(760, 320, parts)


def stiffness() -> str:
    """A stiff beam on three supports: the share of the middle one, by its stiffness."""
    parts = [label(20, 25, "A rigid block on three supports", "t"), square(40, 90, 280, 60)]
    parts += [square(x, 150, 30, 40, 'class="b"') for x in (40, 165, 290)]
    parts += [arrow(180, 45, 0, 75, "r"), label(188, 70, "W")]
    parts += [curve([(20, 190), (340, 190)], GREY)]
    parts += [
        label(55, 215, "k", "s", "middle"), label(180, 215, "k'", "s", "middle"),
        label(305, 215, "k", "s", "middle"),
        label(20, 250, "Two equations, three unknown forces:"),
        label(20, 272, "the outer ones are equal, and R + 2 S = W."),
        label(20, 294, "Rigid statics cannot tell R. Stiffness can.", "s"),
    ]  # fmt: skip
    left, top, width, height = 440, 60, 290, 180
    parts.append(label(400, 25, "Share of the weight on the middle support", "t"))
    parts += axes(left, top, width, height, "k' / k", "R / W = k' / (k' + 2 k)")
    ratios = np.logspace(-2.0, 2.0, 33)
    points = [(math.log10(r), r / (r + 2.0)) for r in ratios]
    parts.append(
        curve([(left + width * (x + 2) / 4, top + height * (1 - y)) for x, y in points], BLUE)
    )
    for power in (-2, -1, 0, 1, 2):
        at = left + width * (power + 2) / 4
        parts.append(label(at, top + height + 18, f"{10.0**power:g}", "s", "middle"))
    for share in (0.0, 0.5, 1.0):
        parts.append(label(left - 8, top + height * (1 - share) + 5, f"{share:g}", "s", "end"))
    return svg(760, 320, parts)


def mechanism() -> str:
    """The collapse mechanism of an arch that is too thin (computed), as a proof."""
    result = drystone.check(drystone.Model.of(arch(THIN, 11), friction=0.7))
    if result.mechanism is None:
        raise SystemExit("the thin arch has no mechanism")
    assembly = result.model.assembly
    step = 0.25 / np.abs(result.mechanism[:, :3]).max()

    def place(points: np.ndarray) -> list[tuple[float, float]]:
        return [(250 + 190 * x, 260 - 190 * z) for x, _, z in points.tolist()]

    parts = [label(20, 25, "The motion that proves that the arch falls", "t")]
    for block, motion in zip(assembly.blocks, step * result.mechanism, strict=True):
        section = [max(block.faces, key=lambda face: -block.vertices[list(face), 1].mean())]
        corners = block.vertices[list(section[0])]
        parts.append(path(place(corners), DASHED))
        arm = corners - block.centroid
        parts.append(path(place(corners + motion[:3] + np.cross(motion[3:], arm))))
    parts += [
        curve([(20, 262), (480, 262)], GREY),
        label(510, 90, "dashed: at rest", "s"),
        label(510, 112, "filled: first motion, enlarged", "s"),
        label(510, 150, "The weight does work: p · v > 0."),
        label(510, 172, "Corners open or slide apart:"),
        label(510, 194, "d_n ≥ μ |d_t| at each of them."),
        label(510, 228, "Contact forces within friction"),
        label(510, 250, "resist no part of this motion."),
    ]
    return svg(760, 290, parts)


def margin() -> str:
    """A block on a slope: the verdict, and how much of its base still presses."""
    width, height = 1.0, 2.0
    limit = math.degrees(math.atan(width / height))
    base, top = box((3.0, 1.0, 0.5), name="ground"), box((width, 1.0, height), (1.0, 0.0, 0.5))
    assembly = drystone.Assembly((base, top), np.array([True, False]))
    left, high, across, down = 90, 60, 420, 190
    parts = [label(20, 25, "A block, twice as high as wide, on ground that is tilted", "t")]
    parts += axes(left, high, across, down, "tilt [degrees]", "share of the base that presses")
    line = []
    for angle in np.linspace(0.0, limit, 41):
        away = 0.5 * height * math.tan(math.radians(angle))
        line.append((angle, min(1.0, 3.0 * (0.5 - away / width))))
    parts.append(curve([(left + across * a / 32, high + down * (1 - s)) for a, s in line], BLUE))
    for angle in (0, 10, 20, 30):
        at = left + across * angle / 32
        parts.append(label(at, high + down + 25, str(angle), "s", "middle"))
    for share in (0.5, 1.0):
        parts.append(label(left - 8, high + down * (1 - share) + 5, f"{share:g}", "s", "end"))
    for angle in (0.0, 8.0, 16.0, 24.0, 26.0, 27.0, 30.0):
        load = drystone.LoadCase.tilt(assembly, (0.0, 1.0, 0.0), angle)
        stands = drystone.check(drystone.Model.of(assembly, friction=0.9, load=load)).stable
        at, colour = left + across * angle / 32, BLUE if stands else RED
        parts.append(f'<circle cx="{at:.0f}" cy="{high + down + 5:.0f}" r="6" fill="{colour}"/>')
    parts += [
        label(540, 90, "dots: verdict of drystone"),
        coloured(BLUE, 540, 112, "blue: STABLE"),
        coloured(RED, 540, 134, "red: UNSTABLE"),
        label(540, 168, f"It falls at atan(1/2) = {limit:.1f}."),
        label(540, 190, "At 26 degrees it is STABLE"),
        label(540, 212, "and presses on 4 % of its base."),
        label(540, 234, "Whether that edge crushes is not asked.", "s"),
    ]
    return svg(780, 310, parts)


DRAWINGS: dict[str, Callable[[], str]] = {
    "prestress": prestress,
    "coupled": coupled,
    "springs": springs,
    "stiffness": stiffness,
    "mechanism": mechanism,
    "margin": margin,
}
"""By the name of the file, ``concept-NAME.svg``."""


def main(folder: Path = Path()) -> None:
    """Write all of them."""
    for name, draw in DRAWINGS.items():
        write_bytes(folder / f"concept-{name}.svg", draw().encode())


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
