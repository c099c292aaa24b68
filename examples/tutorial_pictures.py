"""The pictures of the tutorials.

python examples/tutorial_pictures.py docs/images
"""

import sys
from pathlib import Path

import drystone
from drystone.models import arch, bridge, h_model

SIZE = (8.0, 4.4)
"""Inches."""


def main(folder: Path = Path()) -> None:
    """Check, plan and draw what each tutorial asks about."""
    thin = drystone.Model.of(arch(thickness_ratio=0.1, voussoirs=11), friction=0.7)
    span = arch(thickness_ratio=0.15, voussoirs=11)
    cart = drystone.LoadCase.point_load(span, "voussoir-03", (0.0, 0.0, -500.0))  # N
    loaded = drystone.LoadCase.gravity(span) + cart
    pictures = {
        "architect": drystone.check(thin),
        "engineer": drystone.check(span, friction=0.7, load=loaded),
        "roboticist": drystone.plan(drystone.Model.of(bridge(), friction=0.5)),
        "researcher": drystone.check(h_model(), friction=0.84),
    }
    for name, subject in pictures.items():
        drystone.save_figure(subject, folder / f"tutorial-{name}.png", size=SIZE, dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
