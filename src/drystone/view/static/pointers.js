// Pointers and wheel. A press that does not move is a click; a pointer that rests hovers. What a press
// has grabbed is dragged in place of the camera, until a second finger comes.

const REST = 40; // [ms] of rest before one asks what lies under the pointer
const STILL = 4; // [CSS pixels] of way up to which a press has not moved

function followPointers(canvas, camera, { clicked, hovered, grabbed }) {
  const down = new Map();
  let travelled = 0;
  let resting = 0;
  let held = null; // { move(event), end(whether it counts) }
  const spread = () => {
    const [a, b] = [...down.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  const letGo = (counts) => {
    held?.end(counts);
    held = null;
  };
  canvas.addEventListener("pointerdown", (event) => {
    hovered(null);
    canvas.setPointerCapture(event.pointerId);
    if (down.size === 0) [travelled, held] = [0, grabbed(event)];
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (down.size > 1) {
      travelled = Infinity;
      letGo(false);
    }
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = down.get(event.pointerId);
    if (!last) {
      clearTimeout(resting);
      if (event.pointerType !== "touch") resting = setTimeout(() => hovered(event), REST);
      return;
    }
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    const before = down.size === 2 ? spread() : null;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    travelled += Math.hypot(dx, dy);
    const height = canvas.clientHeight;
    if (held) {
      if (travelled > STILL) held.move(event);
    } else if (before) {
      const after = spread();
      camera.pan((after.x - before.x) / height, (after.y - before.y) / height);
      if (after.size > 0) camera.zoom(before.size / after.size);
    } else if (event.shiftKey || event.buttons & 6) {
      camera.pan(dx / height, dy / height);
    } else if (travelled > STILL) {
      camera.orbit((dx / height) * 4, (dy / height) * 4);
    }
  });
  const release = (event) => {
    const known = down.delete(event.pointerId);
    const lifted = event.type === "pointerup";
    letGo(lifted && travelled > STILL);
    // a finger that rests long is lifted without the click of the browser
    if (known && lifted && travelled <= STILL && event.button === 0) clicked(event);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointerleave", (event) => {
    clearTimeout(resting);
    if (event.pointerType !== "touch") hovered(null); // what a finger was told stays to be read
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    hovered(null);
    const pixels = event.deltaMode === 0 ? event.deltaY : 30 * event.deltaY;
    camera.zoom(Math.exp(Math.max(-200, Math.min(200, pixels)) * 0.0015));
  }, { passive: false });
}
