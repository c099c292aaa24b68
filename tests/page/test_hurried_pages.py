"""Pages that draw slowly draw less while the model is turned, and all of it when it rests."""

from __future__ import annotations

from benchmarks.page import COUNT, standing_wall
from drystone.view import page_text, scene_of

SLOW = """
const kind = WebGL2RenderingContext.prototype;
const [own, clear, blit] = [kind.clientWaitSync, kind.clear, kind.blitFramebuffer];
const since = new WeakMap();
kind.clientWaitSync = function (fence, ...given) { // no picture is done within 150 ms
  if (!since.has(fence)) since.set(fence, performance.now());
  const early = performance.now() < since.get(fence) + 150;
  return early ? this.TIMEOUT_EXPIRED : own.call(this, fence, ...given);
};
let begun = 0;
kind.clear = function (...given) {
  begun = window.drawn.triangles;
  clear.apply(this, given);
};
kind.blitFramebuffer = function (...given) { // a whole picture is done
  window.whole = window.drawn.triangles - begun;
  blit.apply(this, given);
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
    assert tab.run(RESTS) == whole
    assert tab.picture("#view") == picture
