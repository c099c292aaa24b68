"""The two drawings of the documentation: the layers of the code, and the sign conventions.

python examples/diagrams.py docs/images

The layers are read from the import contract in pyproject.toml, so that the drawing shows what is
enforced.
"""

import sys
import tomllib
from html import escape
from pathlib import Path

import drystone.base.files

ROOT = Path(__file__).parents[1]

FLOORS = {
    "Show": ("cli", "gym", "live", "mcp", "reproduce", "report", "view"),
    "Design and plan": ("design", "compat", "sequence", "shells", "studies", "seismic", "models"),
    "Analyse": (
        "limits",
        "programs",
        "stability",
        "settlement",
        "fall",
        "poses",
        "formulations",
        "mechanics",
    ),
    "Describe": (
        "io",
        "results",
        "answer",
        "statics",
        "checks",
        "joints",
        "friction_use",
        "virtual",
        "free_faces",
        "ties",
        "model",
        "detection",
        "contacts",
    ),
    "Blocks": ("joint_capacity", "loads", "mesh_objects", "repair", "supports", "assembly"),
    "Numbers": ("solvers", "geometry"),
    "Ground": ("base",),
}
"""Layers of the contract, gathered by purpose; from the top."""

STYLE = (
    "<style>text{font:15px sans-serif;fill:#1a1a1a}.b{fill:#f4f1ea;stroke:#6b6459}"
    ".t{font-weight:bold}.s{font-size:13px;fill:#55504a}.a{stroke:#1f5fa8;fill:none;"
    "stroke-width:2.5}.r{stroke:#b3261e;fill:none;stroke-width:2.5}</style>"
)


def layers() -> list[str]:
    """Names of all layers that exist, from the top."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    rows = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    names = [name.strip(" ()") for row in rows for name in row.split("|")]
    source = ROOT / "src" / "drystone"
    return [n for n in names if (source / n).is_dir() or (source / f"{n}.py").is_file()]


def svg(width: int, height: int, parts: list[str]) -> str:
    """A drawing on white, readable in light and dark pages alike."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">'
        f'{STYLE}<rect width="{width}" height="{height}" fill="#fff"/>'
        + "".join(parts)
        + "</svg>\n"
    )


def label(x: float, y: float, text: str, kind: str = "", anchor: str = "start") -> str:
    """A line of text."""
    return f'<text x="{x}" y="{y}" class="{kind}" text-anchor="{anchor}">{escape(text)}</text>'


def house() -> str:
    """The layers as floors; a module imports from floors below, and from the right."""
    existing, parts = layers(), []
    for row, (purpose, members) in enumerate(FLOORS.items()):
        top = 20 + 62 * row
        parts.append(label(20, top + 29, purpose, "t"))
        for column, name in enumerate(n for n in existing if n in members):
            left = 165 + 104 * column
            parts.append(f'<rect x="{left}" y="{top}" width="96" height="46" rx="4" class="b"/>')
            parts.append(label(left + 48, top + 29, name, anchor="middle"))
    bottom = 20 + 62 * len(FLOORS)
    parts.append(label(20, bottom + 14, "A layer imports only from layers below it.", "s"))
    return svg(1200, bottom + 30, parts)


def arrow(x: float, y: float, dx: float, dy: float, kind: str = "a") -> str:
    """An arrow with a plain head."""
    length = (dx * dx + dy * dy) ** 0.5
    ux, uy = dx / length, dy / length
    x2, y2 = x + dx, y + dy
    wings = [(x2 - 11 * ux - 5 * s * uy, y2 - 11 * uy + 5 * s * ux) for s in (1, -1)]
    head = " L ".join(f"{px:.1f} {py:.1f}" for px, py in (wings[0], (x2, y2), wings[1]))
    return f'<path d="M {x} {y} L {x2} {y2} M {head}" class="{kind}"/>'


def signs() -> str:
    """Frame of an interface, the force of a corner, the wrench and the motion of a block."""
    quad = "M 110 235 L 300 235 L 370 175 L 180 175 Z"
    parts = [
        '<path d="M 110 330 L 110 235 L 300 235 L 300 330 Z M 300 330 L 370 270 L 370 175 '
        'L 300 235 Z" class="b"/>',
        f'<path d="{quad}" fill="#cfe0f3" stroke="#6b6459"/>',
        label(205, 290, "block a", "t", "middle"),
        '<path d="M 110 235 L 110 90 L 300 90 L 300 235 M 110 90 L 180 30 L 370 30 L 300 90 '
        'M 370 30 L 370 175" fill="none" stroke="#6b6459" stroke-dasharray="5 4"/>',
        label(150, 120, "block b", "t"),
        arrow(240, 205, 0, -75),
        label(248, 140, "n"),
        arrow(240, 205, 80, 0),
        label(312, 198, "u"),
        arrow(240, 205, 40, -34),
        label(284, 166, "v"),
        '<circle cx="110" cy="235" r="5" fill="#b3261e"/>',
        arrow(110, 235, -26, -80, "r"),
        label(20, 160, "force of"),
        label(20, 178, "a corner"),
        label(440, 50, "Interface", "t"),
        label(440, 72, "Frame (n, u, v): right-handed unit vectors."),
        label(440, 92, "n points from block a to block b."),
        label(440, 124, "Force of a corner (n, u, v) [N]", "t"),
        label(440, 146, "It acts on block b; block a feels the opposite."),
        label(440, 166, "n ≥ 0: compression.  √(u² + v²) ≤ μ n: friction."),
        label(440, 198, "Wrench of a block (6) [N, N m]", "t"),
        label(440, 220, "Force and moment about the centroid, world axes."),
        label(440, 252, "Motion of a block (6) [m, rad]", "t"),
        label(440, 274, "Translation of the centroid and rotation vector w."),
        label(440, 294, "A point p moves by t + w × (p − centroid)."),
        label(440, 326, "Gravity: −z, 9.81 m/s², unless told otherwise.", "s"),
    ]
    return svg(820, 360, parts)


def main(folder: Path = Path()) -> None:
    """Write both drawings."""
    drawings = {"house": house(), "signs": signs()}
    for name, drawing in drawings.items():
        drystone.base.files.write_bytes(folder / f"{name}.svg", drawing.encode())


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
