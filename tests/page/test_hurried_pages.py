"""Pages that draw slowly draw less while the model is turned, and all of it when it rests."""

from __future__ import annotations

from benchmarks.page import COUNT, standing_wall
from drystone.view import page_text, scene_of

SLOW = """
const kind = WebGL2RenderingContext.prototype;
const [own, clear, blit, put] = [
  kind.clientWaitSync, kind.clear, kind.blitFramebuffer, kind.drawElements,
];
const since = new WeakMap();
let least = 150;
kind.clientWaitSync = function (fence, ...given) { // no picture is done within so many ms
  if (!since.has(fence)) since.set(fence, performance.now());
  const early = performance.now() < since.get(fence) + least;
  return early ? this.TIMEOUT_EXPIRED : own.call(this, fence, ...given);
};
let [begun, lines] = [0, 0];
kind.clear = function (...given) {
  begun = window.drawn.triangles;
  lines = 0;
  least = 150;
  clear.apply(this, given);
};
kind.blitFramebuffer = function (...given) { // a whole picture is done
  window.whole = window.drawn.triangles - begun;
  least = 350;
  blit.apply(this, given);
};
kind.drawElements = function (mode, ...given) { // lines of one pixel: a sharp picture before it
  if (mode === this.LINES) window.sharp = [this.canvas.width, this.canvas.height, ++lines];
  put.call(this, mode, ...given);
};"""
RESTS = """(async () => { // until nothing has been drawn for a while
  for (let calls = -1; calls !== window.drawn.calls;) {
    calls = window.drawn.calls;
    await new Promise((done) => setTimeout(done, 600));
  }
  const { whole } = window;
  delete window.whole;
  return Math.round(whole);
})()"""
TURN = """(async () => { // the triangles of the next picture
  window.drawn = { calls: 0, triangles: 0 };
  document.getElementById('view').dispatchEvent(new KeyboardEvent('keydown', { key: 'KEY' }));
  while (window.drawn.calls === 0) await new Promise(requestAnimationFrame);
  return Math.round(window.drawn.triangles);
})()"""


def test_a_page_that_draws_slowly_draws_less_while_it_is_turned_and_all_of_it_at_rest(opened):
    text = page_text(scene_of(standing_wall(30)))
    assert "const MANY = 1000;" in text  # blocks, from which edges wait
    text = text.replace("const MANY = 1000;", "const MANY = 10;")
    tab = opened(lambda path: path.write_text(text), before=COUNT + SLOW)
    whole, picture = tab.run(RESTS), tab.picture("#view")
    for key in ("ArrowLeft", "ArrowRight"):
        assert 0 < tab.run(TURN.replace("KEY", key)) < 0.4 * whole
        assert not tab.run("document.getElementById('drawing').hidden")  # forces wait
    assert tab.run(RESTS) == whole
    assert tab.run("document.getElementById('drawing').hidden")
    assert tab.picture("#view") == picture
    # a picture with every pixel and with the edges in front came before the whole one
    assert tab.run("window.sharp") == [tab.run("view.width"), tab.run("view.height"), 1]
