"""Two short moving pictures: a thin arch that falls, and the assembly of a corbelled bridge.

python examples/moving_pictures.py docs
"""

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import drystone
from drystone.assembly import Assembly
from drystone.base.files import write_bytes
from drystone.geometry.frames import rotation_about
from drystone.models import arch, corbelled_bridge
from drystone.settlement import SettlementOptions
from drystone.view import scene_of

SIZE = (6.4, 3.6)
"""Inches."""


def moved(assembly: Assembly, motion: np.ndarray) -> Assembly:
    """Blocks after a motion (n, 6): translation of the centroid, and rotation vector."""
    blocks = []
    for block, (*way, x, y, z) in zip(assembly.blocks, motion, strict=True):
        angle = float(np.linalg.norm((x, y, z)))
        turn = rotation_about((x, y, z), np.degrees(angle)) if angle else np.eye(3)
        blocks.append(block.transformed(turn, block.centroid + way - turn @ block.centroid))
    return Assembly(tuple(blocks), assembly.fixed)


def picture(subject: object, folder: Path, **options: object) -> Image.Image:
    """One frame."""
    path = folder / "frame.png"
    drystone.save_figure(subject, path, size=SIZE, dpi=80, **options)
    frame = Image.open(io.BytesIO(path.read_bytes())).convert("P", palette=Image.Palette.ADAPTIVE)
    path.unlink()
    return frame


def save(frames: list[Image.Image], path: Path, milliseconds: int) -> None:
    """An endless GIF that waits on its last frame."""
    times = [milliseconds] * (len(frames) - 1) + [1500]
    made = io.BytesIO()
    frames[0].save(
        made, "GIF", save_all=True, append_images=frames[1:], duration=times, loop=0, optimize=True
    )
    write_bytes(path, made.getvalue())


def fall(folder: Path, count: int) -> list[Image.Image]:
    """An arch that is too thin, followed by finite steps."""
    model = drystone.Model.of(arch(thickness_ratio=0.1, voussoirs=15), friction=0.7)
    far = SettlementOptions(fall=4.0)
    positions = drystone.settle(model, options=far).paths[0].positions
    size = np.abs(positions).max(axis=(1, 2))
    chosen = [int(np.searchsorted(size, share * size[-1])) for share in np.linspace(0, 1, count)]
    view = (0.15, -1.0, 0.1)
    return [
        picture(moved(model.assembly, positions[step]), folder, toward=view, preset="solid")
        for step in chosen
    ]


def plan(folder: Path, count: int) -> list[Image.Image]:
    """A bridge that is built out from both sides."""
    model = drystone.Model.of(corbelled_bridge(), friction=0.7)
    scene = scene_of(drystone.plan(model))
    stages = range(len(scene.stages))[:count]
    view = (0.3, -1.0, 0.25)
    return [picture(scene, folder, stage=stage, toward=view) for stage in stages]


def main(folder: Path = Path(), count: int = 24) -> None:
    """Draw and write both."""
    save(fall(folder, count), folder / "fall.gif", 80)
    save(plan(folder, count), folder / "plan.gif", 700)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
