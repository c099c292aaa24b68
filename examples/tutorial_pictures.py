"""The pictures of the pages *Ten minutes*.

python examples/tutorial_pictures.py docs/images
"""

import sys
from pathlib import Path

import drystone
from drystone.design import MendOptions, find_mends
from drystone.models import arch, vault

SIZE = (8.0, 4.4)
"""Inches."""


def main(folder: Path = Path()) -> None:
    """Check, mend, plan and draw."""
    thin = drystone.Model.of(arch(thickness_ratio=0.1, voussoirs=11), friction=0.7)
    thick = drystone.Model.of(arch(thickness_ratio=0.15, voussoirs=11), friction=0.7)
    mended = find_mends(thin, options=MendOptions(kinds=("thicker",))).mends[0].result
    pictures = {
        "vault": drystone.check(vault(), friction=0.6),
        "fall": drystone.check(thin),
        "mend": mended,
        "plan": drystone.plan(thick),
    }
    for name, subject in pictures.items():
        drystone.save_figure(subject, folder / f"ten-minutes-{name}.png", size=SIZE, dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
