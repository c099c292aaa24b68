"""Two short moving pictures: a thin arch that falls, and the assembly of a corbelled bridge.

python examples/moving_pictures.py docs/images

It needs the extra fall and Pillow, which matplotlib brings.
"""

import sys
from pathlib import Path
from typing import TypeAlias

import numpy as np
from matplotlib.figure import Figure

import drystone
from drystone.assembly import Assembly
from drystone.fall import fall
from drystone.geometry.frames import rotation_about
from drystone.models import arch, corbelled_bridge
from drystone.view import Scene, scene_of
from drystone.view.gif import write_gif

SIZE = (8.2, 4.4)
"""Inches."""
ROOM = 0.05
"""Share of the width that is left free on each side of the blocks."""

Picture: TypeAlias = tuple[Figure, np.ndarray]


def moved(assembly: Assembly, motion: np.ndarray) -> Assembly:
    """Blocks after a motion (n, 6): translation of the centroid, and rotation vector."""
    blocks = []
    for block, (*way, x, y, z) in zip(assembly.blocks, motion, strict=True):
        angle = float(np.linalg.norm((x, y, z)))
        turn = rotation_about((x, y, z), np.degrees(angle)) if angle else np.eye(3)
        blocks.append(block.transformed(turn, block.centroid + way - turn @ block.centroid))
    return Assembly(tuple(blocks), assembly.fixed)


def drawn(scene: Scene, toward: tuple[float, float, float], **options: object) -> Picture:
    """A picture of blocks without words, and where the middle of the model is on the paper.

    Nobody could read words at the width of a phone.
    """
    figure = drystone.save_figure(scene, size=SIZE, toward=toward, **options)
    axes = figure.axes[0]
    words = [*figure.texts, *figure.legends, *figure.axes[1:], *axes.texts, *axes.patches]
    for one in [*words, *axes.lines]:
        one.remove()
    axes.set_position((0.0, 0.0, 1.0, 1.0))
    axes.set_adjustable("box")
    eye = np.array(toward) / np.linalg.norm(toward)
    right = np.cross((0.0, 0.0, 1.0), eye)
    right /= np.linalg.norm(right)
    return figure, np.array([right, np.cross(eye, right)]) @ scene.centre


def framed(pictures: list[Picture]) -> list[Figure]:
    """Figures of one place: all that one of them shows, and some room around it."""
    boxes = [(figure.axes[0].dataLim, place) for figure, place in pictures]
    low = np.min([place + box.min for box, place in boxes], axis=0)
    high = np.max([place + box.max for box, place in boxes], axis=0)
    width, height = high - low
    width = (1.0 + 2.0 * ROOM) * max(width, height * SIZE[0] / SIZE[1])
    half = 0.5 * np.array([width, width * SIZE[1] / SIZE[0]])
    middle = 0.5 * (low + high)
    for figure, place in pictures:
        (left, low), (right, high) = middle - half - place, middle + half - place
        figure.axes[0].set(xlim=(left, right), ylim=(low, high))
    return [figure for figure, _ in pictures]


def save(figures: list[Figure], path: Path, milliseconds: int) -> None:
    """An endless GIF that waits on its first and its last frame."""
    write_gif(figures, path, [1000] + [milliseconds] * (len(figures) - 2) + [2000])


def falling(count: int) -> list[Figure]:
    """An arch that is too thin, until it lies on the ground."""
    model = drystone.Model.of(arch(thickness_ratio=0.1, voussoirs=15), friction=0.7)
    film = fall(model, drystone.check(model).mechanism)
    away = np.abs(film.positions - film.positions[-1]).max(axis=(1, 2))
    lies = int(np.argmax(away < 0.02))
    chosen = np.linspace(0, lies, count).astype(int)
    scenes = [scene_of(moved(model.assembly, film.positions[step])) for step in chosen]
    figures = [drawn(scene, (0.15, -1.0, 0.25), preset="solid") for scene in scenes]
    return framed(figures)


def built(count: int) -> list[Figure]:
    """A bridge that is built out from both sides."""
    model = drystone.Model.of(corbelled_bridge(), friction=0.7)
    scene = scene_of(drystone.plan(model))
    stages = range(len(scene.stages))[-count:]
    figures = [drawn(scene, (0.3, -1.0, 0.25), stage=stage) for stage in stages]
    return framed(figures)


def main(folder: Path = Path(), count: int = 30) -> None:
    """Draw and write both."""
    save(falling(count), folder / "fall.gif", 60)
    save(built(count), folder / "plan.gif", 700)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
