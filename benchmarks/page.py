"""How large a page is, how long it takes to open and to draw: ``python -m benchmarks.page``.

Needs a Chromium. It draws without a graphics card (SwiftShader), which is the slow end. Triangles
and calls of a picture say what a card has to do. The time of its script, with calls that draw
nothing, says what is left for the processor. Interfaces carry made-up forces, so that nothing is
solved.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import drystone
from benchmarks.machine import commit, processor
from drystone.assembly import Assembly
from drystone.model import Model
from drystone.models import wall
from drystone.results import Result, Verdict
from drystone.view import page_text, scene_of
from tests.page.browser import executable, running

SIZES = (100, 400, 10_000, 100_000)
FRAMES = 10
"""Pictures of which the median time is told."""


def standing_wall(count: int) -> Result:
    """A wall of about so many blocks, each corner of an interface with a force."""
    courses = max(2, int(np.sqrt(count)))
    assembly: Assembly = wall(courses, max(2, count // courses))
    model = Model.of(assembly)
    force = np.zeros((model.contacts.corner_count, 3))
    height = model.contacts.point[:, 2]
    force[:, 0] = 1000.0 * (1.0 + height.max() - height)
    return Result("check", Verdict.STABLE, model, "made up", force=force)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, nargs="*", default=SIZES)
    chosen = parser.parse_args()
    program = executable()
    if program is None:
        raise SystemExit("no Chromium on this machine; the variable CHROMIUM can name one")
    print(f"drystone {drystone.__version__}, commit {commit()}; {processor()}")
    print("| blocks | interfaces | page [MB] | written [s] | opened [s] | turning [ms] "
          "| triangles | calls | at rest [ms] | triangles | calls | script [ms] "
          "| left out |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, running(program) as browser:
        for count in chosen.blocks:
            result = standing_wall(count)
            began = time.perf_counter()
            text = page_text(scene_of(result))
            written = time.perf_counter() - began
            path = Path(folder) / "page.html"
            path.write_text(text, encoding="utf-8")
            began = time.perf_counter()
            tab = browser.open(path, size=(1600, 1000), ratio=1.0, before=COUNT)
            opened = time.perf_counter() - began
            turning = tab.run(FRAME.replace("FRAMES", str(FRAMES)))
            rest = tab.run(REST)
            script = tab.run(SCRIPT.replace("FRAMES", str(FRAMES)))
            assert tab.complaints() == [], tab.complaints()
            print(
                f"| {len(result.assembly):,} | {result.contacts.count:,} | {len(text) / 1e6:.2f} "
                f"| {written:.2f} | {opened:.2f} | {turning['time']:.0f} "
                f"| {turning['triangles']:,.0f} | {turning['calls']:.0f} | {rest['time']:.0f} "
                f"| {rest['triangles']:,.0f} | {rest['calls']} | {script:.1f} "
                f"| {'said' if 'without details' in tab.text('#asked') else 'nothing'} |",
                flush=True,
            )
            tab.close()


COUNT = """
window.drawn = { calls: 0, triangles: 0 };
for (const [name, at, copies] of [["drawElements", 1, 9], ["drawArrays", 2, 9],
                                  ["drawElementsInstanced", 1, 4], ["drawArraysInstanced", 2, 3]]) {
  const own = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...given) {
    window.drawn.calls += 1;
    window.drawn.triangles += given[at] / 3 * (given[copies] ?? 1);
    return window.muted ? undefined : own.apply(this, given);
  };
}
const copy = WebGL2RenderingContext.prototype.blitFramebuffer; // shows a whole picture
WebGL2RenderingContext.prototype.blitFramebuffer = function (...given) {
  copy.apply(this, given);
  this.bindFramebuffer(this.READ_FRAMEBUFFER, null);
  // until it is drawn
  this.readPixels(0, 0, 1, 1, this.RGBA, this.UNSIGNED_BYTE, new Uint8Array(4));
  window.shown = performance.now();
};
const later = window.requestAnimationFrame.bind(window);
window.scripts = [];
window.requestAnimationFrame = (next) => later((now) => {
  const began = performance.now();
  next(now);
  window.scripts.push(performance.now() - began);
});"""

SCRIPT = """(async () => {
  const view = document.getElementById('view');
  window.muted = true; // calls are made and counted, and nothing is drawn
  window.drawn = { calls: 0, triangles: 0 };
  const times = [];
  for (let i = 0; i < FRAMES; i++) {
    await new Promise((done) => setTimeout(done, 20));
    window.scripts = [];
    view.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }));
    await new Promise((done) => setTimeout(done, 100));
    times.push(Math.max(0, ...window.scripts));
  }
  window.muted = false;
  times.sort((a, b) => a - b);
  return times[Math.floor(times.length / 2)];
})()"""

REST = """(async () => {
  const view = document.getElementById('view');
  const idle = async () => { // until nothing has been drawn for half a second
    for (let calls = -1; calls !== window.drawn.calls;) {
      calls = window.drawn.calls;
      await new Promise((done) => setTimeout(done, 500));
    }
  };
  await idle();
  window.drawn = { calls: 0, triangles: 0 };
  const began = performance.now();
  window.dispatchEvent(new Event('resize'));
  while (!(window.shown > began)) await new Promise((done) => setTimeout(done, 100));
  await idle();
  return { ...window.drawn, time: window.shown - began };
})()"""

FRAME = """(async () => {
  const view = document.getElementById('view');
  const gl = view.getContext('webgl2');
  const pixel = new Uint8Array(4);
  // until it is drawn
  const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  const turn = async () => {
    view.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }));
    await new Promise(requestAnimationFrame);
    wait();
  };
  for (let i = 0; i < FRAMES; i++) await turn(); // the page learns how slow pictures are
  window.drawn = { calls: 0, triangles: 0 };
  const times = [];
  for (let i = 0; i < FRAMES; i++) {
    const began = performance.now();
    await turn();
    times.push(performance.now() - began);
  }
  const { calls, triangles } = window.drawn;
  times.sort((a, b) => a - b);
  const time = times[Math.floor(times.length / 2)];
  return { time, calls: calls / FRAMES, triangles: triangles / FRAMES };
})()"""


if __name__ == "__main__":
    main()
