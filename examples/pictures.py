"""The pictures of the README: a vault that stands, and a shelf that only seems to.

python examples/pictures.py docs/images
"""

import sys
from pathlib import Path

import drystone
from drystone.models import shelf, vault

SIZE = (7.0, 4.0)
"""Inches."""


def main(folder: Path = Path()) -> tuple[drystone.Result, drystone.Result]:
    """Check both models and draw them."""
    standing = drystone.check(vault(), friction=0.6)
    drystone.save_figure(standing, folder / "vault.png", size=SIZE, dpi=130)
    falling = drystone.check(shelf(), friction=0.9)
    view = (0.25, -1.0, 0.2)
    drystone.save_figure(falling, folder / "shelf.png", size=(7.0, 5.4), dpi=130, toward=view)
    return standing, falling


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
