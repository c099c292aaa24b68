"""A film of one minute, of our own pages: a vault found, cut, built, tilted until it falls, mended.

    pip install ".[fall,film]"
    python docs/site/film.py docs/images/film.mp4

It needs a Chromium, which draws without a graphics card (some ten minutes), and imageio-ffmpeg.
"""

from __future__ import annotations

import argparse
import base64
import io
import json
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qsl, urlencode, urlsplit

import imageio_ffmpeg
import numpy as np
from PIL import Image

import drystone
from drystone.answer.scene import Layer, LayerKind, Scene, SceneStage, State
from drystone.design import MendOptions, find_mends
from drystone.fall import fall
from drystone.sequence import PlanOptions, Rules
from drystone.shells import shell_by_name
from drystone.shells.shell_families import shape_by_name
from drystone.view import save_page, scene_of

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.page.browser import Tab, executable, running

SIZE = (960, 544)
RATE = 12
"""Pictures a second."""
FRICTION = 0.6
STANDS, FALLS = 35.0, 43.0
"""Tilts [degrees] of the fourth part: the last one that stands, and one that falls."""
WORDS = """
main { position: fixed; inset: 0; }
main > :not(#view), aside { display: none !important; }
#film { position: fixed; z-index: 9; left: 40px; bottom: 26px; color: #1d1b18;
  font: 600 27px/1.3 system-ui, sans-serif; }
#film small { display: block; font: 400 18px/1.4 system-ui, sans-serif; }
"""
"""Of a page only the model is left, with words below it."""
SHOWN = """
const copy = WebGL2RenderingContext.prototype.blitFramebuffer; // shows a whole picture
WebGL2RenderingContext.prototype.blitFramebuffer = function (...given) {
  copy.apply(this, given);
  window.shown = performance.now();
};"""
SEEN = """(async () => {
  const began = performance.now();
  if (location.hash !== '#' + VIEW) {
    const read = new Promise((done) => addEventListener('hashchange', done, { once: true }));
    location.hash = VIEW;
    await read;
  }
  const slide = document.getElementById('motion');
  slide.value = MOVED ?? slide.value;
  slide.dispatchEvent(new Event('input'));
  while (!(window.shown > began)) await new Promise((done) => setTimeout(done, 10));
})()"""
"""Goes to a view and a place of the motion, and waits until the whole picture is drawn."""

Place = Callable[[float], dict[str, float]]
"""By the share of a shot, 0 to 1: stage ``s``, how far apart ``e``, and the motion ``moved``."""


@dataclass
class Shot:
    """Some seconds of one page."""

    subject: object
    seconds: float
    words: str
    more: str
    place: Place
    azimuth: tuple[float, float] = (-125.0, -115.0)
    elevation: float = 24.0
    room: float = 1.0
    preset: str = ""


def smooth(share: float) -> float:
    """Slow at both ends."""
    return share * share * (3.0 - 2.0 * share)


def surface(shell: object, steps: int = 24) -> Scene:
    """A flat net that rises until its bars carry the weight: the surface that is found."""
    shape, _ = shape_by_name("free-edge")
    along = np.linspace(0.0, 1.0, 15)
    corners, loops = [], [0]
    for patch in shape.patches:
        u, v = np.meshgrid(along, along, indexing="ij")
        grid = patch.point(u, v)
        for i in range(len(along) - 1):
            for j in range(len(along) - 1):
                corners += [grid[i, j], grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]]
                loops.append(len(corners))
    assembly = shell.assembly
    absent = np.full(len(assembly), int(State.ABSENT))
    stages = []
    for share in np.linspace(0.0, 1.0, steps):
        place = np.array(corners) * (1.0, 1.0, share)
        shade = 0.55 * place[:, 2] / place[:, 2].max(initial=1e-9)
        faces = Layer("surface", "surface", LayerKind.POLYGONS, "interface", place,
                      start=np.array(loops), value=shade)  # fmt: skip
        ends = np.roll(place.reshape(-1, 4, 3), -1, axis=1).reshape(-1, 3)
        net = Layer("net", "bars of the net", LayerKind.LINES, "network", place,
                    vector=ends - place)  # fmt: skip
        stages.append(SceneStage("", "", "", absent, layers=(faces, net)))
    return Scene(assembly, shell.contacts, tuple(stages))


def shots() -> Iterator[Shot]:
    """The parts of the film, in their order."""
    shell = shell_by_name("free-edge", courses=6)
    model = shell.model(friction=FRICTION)
    rising = surface(shell)
    last = len(rising.stages) - 1
    yield Shot(rising, 8.0, "A vault, found from a plan",
               "a net of bars that carries its weight in compression, with one free edge",
               lambda s: {"s": round(last * smooth(min(1.0, 1.4 * s)))})  # fmt: skip
    stands = drystone.check(model)
    yield Shot(stands, 9.0, f"Cut into {len(shell.voussoirs)} voussoirs",
               "with joints that are plane; each block fits its neighbours",
               lambda s: {"e": 0.45 * np.sin(np.pi * min(1.0, 1.15 * s)) ** 2},
               azimuth=(-115.0, -100.0), preset="solid", room=1.4)  # fmt: skip
    planned = drystone.plan(model, options=PlanOptions(rules=Rules(order="course")))
    scene = scene_of(planned)
    count = len(scene.stages)

    def placed(share: float) -> dict[str, float]:
        at = min(count - 1e-6, share * 1.08 * count)
        within = min(1.0, 2.0 * (at % 1.0))
        return {"s": int(at), "moved": within * (2.0 - within)}

    yield Shot(scene, 16.0, "Built, block by block",
               "every stage is checked: orange is held, red needs a prop",
               placed, azimuth=(-100.0, -70.0), room=0.9)  # fmt: skip
    axis = (-1.0, 0.0, 0.0)
    answers = [
        drystone.check(model.with_load(drystone.LoadCase.tilt(model.assembly, axis, one)))
        for one in np.arange(STANDS + 1.0)
    ]
    if not all(one.stable for one in answers):
        raise SystemExit("it does not stand as far as the film says")
    tilting = Scene(model.assembly, model.contacts, tuple(one.stage("") for one in answers))
    side = (-40.0, -24.0)
    yield Shot(tilting, 8.0, "Tilted",
               f"forces balance it, and a motion causes them: it stands up to {STANDS:.0f} degrees",
               lambda s: {"s": round(STANDS * smooth(s))},
               azimuth=side, elevation=14.0, room=1.0)  # fmt: skip
    steep = model.with_load(drystone.LoadCase.tilt(model.assembly, axis, FALLS))
    falls = fall(steep)
    yield Shot(scene_of(falls), 7.0, f"At {FALLS:.0f} degrees it falls",
               "forces could balance it, but the load alone does not bring them about",
               lambda s: {"moved": min(1.0, 1.2 * s)},
               azimuth=(-24.0, -20.0), elevation=14.0, room=1.35, preset="solid")  # fmt: skip
    mended = find_mends(steep, options=MendOptions(kinds=("prop",))).mends[0]
    yield Shot(mended, 9.0, "Mended",
               f"{mended.change.description.partition(' (')[0]} holds it at the same tilt",
               lambda _: {},
               azimuth=(-20.0, -44.0), elevation=14.0, room=1.25, preset="solid")  # fmt: skip
    yield Shot(stands, 3.0, "drystone", "Does a structure of loose blocks stand?",
               lambda _: {}, azimuth=(-70.0, -75.0), room=1.1)  # fmt: skip


def pictures(tab: Tab, shot: Shot) -> Iterator[Image.Image]:
    """The pictures of a shot."""
    told = f"{shot.words}<small>{shot.more}</small>"
    tab.run(
        "(() => { const s = document.createElement('style'); s.textContent = "
        f"{json.dumps(WORDS)}; document.head.append(s); const f = document.createElement('div'); "
        f"f.id = 'film'; f.innerHTML = {json.dumps(told)}; document.body.append(f); }})()"
    )
    tab.frames(3)
    tab.click("#fit")
    tab.click("#link")
    view = dict(parse_qsl(urlsplit(tab.run("document.getElementById('address').value")).fragment))
    numbers = [float(x) for x in view["v"].split(",")]
    first, last = np.radians(shot.azimuth)
    numbers[1], numbers[2] = np.radians(shot.elevation), shot.room * numbers[2]
    view.pop("a", None)  # the eye moves
    if shot.preset:
        view["p"] = shot.preset
    count = round(shot.seconds * RATE)
    for share in np.linspace(0.0, 1.0, count):
        numbers[0] = first + share * (last - first)
        place = shot.place(share)
        moved = place.pop("moved", None)
        words = urlencode({**view, **place, "v": ",".join(f"{x:.7g}" for x in numbers)})
        tab.run(SEEN.replace("MOVED", json.dumps(moved)).replace("VIEW", json.dumps(words)))
        got = tab.send("Page.captureScreenshot", format="jpeg", quality=92)["data"]
        yield Image.open(io.BytesIO(base64.b64decode(got))).convert("RGB")


def main() -> None:
    """Write the film."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--every", type=int, default=1, help="draw only every so many pictures")
    chosen = parser.parse_args()
    program = executable()
    if program is None:
        raise SystemExit("no Chromium on this machine; the variable CHROMIUM can name one")
    global RATE
    RATE = max(1, RATE // chosen.every)
    writer = imageio_ffmpeg.write_frames(
        str(chosen.out), SIZE, fps=RATE, codec="libx264", quality=None,
        output_params=["-crf", "27", "-preset", "slow", "-movflags", "+faststart"],
    )  # fmt: skip
    writer.send(None)
    with tempfile.TemporaryDirectory() as folder, running(program) as browser:
        for shot in shots():
            page = Path(folder) / "page.html"
            save_page(shot.subject, page)
            tab = browser.open(page, size=SIZE, ratio=1.0, before=SHOWN)
            for image in pictures(tab, shot):
                writer.send(np.asarray(image).tobytes())
            if tab.complaints():
                raise SystemExit("\n".join(tab.complaints()))
            tab.close()
            print(f"{shot.words}: {shot.seconds:.0f} s", flush=True)
    writer.close()
    print(f"{chosen.out}: {chosen.out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
