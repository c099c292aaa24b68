// An orbiting eye: z is up, distances in metres from the middle of the model.

const FIELD_OF_VIEW = (28 * Math.PI) / 180;
const FRAME = 1.18; // room around the model for the texts at the edges

class Camera {
  constructor(half, toward, changed) {
    this.half = half; // of the sides of the box around the model
    this.radius = vec.length(half);
    this.changed = changed;
    this.target = [0, 0, 0];
    this.azimuth = Math.atan2(toward[1], toward[0]);
    this.elevation = Math.asin(toward[2]);
    this.distance = 1;
  }

  fit(azimuth, elevation, aspect) {
    if (azimuth !== undefined) [this.azimuth, this.elevation] = [azimuth, elevation];
    this.target = [0, 0, 0];
    const { right, up, back } = this.axes();
    const slope = Math.tan(FIELD_OF_VIEW / 2);
    this.distance = 0;
    for (let i = 0; i < 8; i++) {
      const corner = this.half.map((size, axis) => (i & (1 << axis) ? size : -size));
      const wide = Math.abs(vec.dot(corner, right)) / (slope * aspect);
      const high = Math.abs(vec.dot(corner, up)) / slope;
      const needed = FRAME * Math.max(wide, high) + vec.dot(corner, back);
      this.distance = Math.max(this.distance, needed);
    }
    this.changed();
  }

  axes() {
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    return { back: [ce * ca, ce * sa, se], right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce] };
  }

  view(aspect) {
    const { right, up, back } = this.axes();
    const eye = vec.add(this.target, vec.scale(back, this.distance));
    const middle = vec.dot(eye, back);
    const reach = 3 * this.radius; // falling blocks leave the sphere around the model
    const far = Math.max(middle + reach, 1e-3 * this.radius);
    const near = Math.max(middle - reach, 2e-3 * Math.min(this.distance, this.radius));
    const lens = perspective(FIELD_OF_VIEW, aspect, near, far);
    const light = [0, 1, 2].map((i) => 0.72 * back[i] + 0.42 * up[i] - 0.55 * right[i]);
    return { projection: multiply(lens, lookFrom(eye, right, up, back)), back, light };
  }

  // Share of the picture's height that a length at the target takes.
  share(length) {
    return length / (2 * this.distance * Math.tan(FIELD_OF_VIEW / 2));
  }

  orbit(dx, dy) {
    const limit = Math.PI / 2 - 1e-4;
    this.azimuth -= dx;
    this.elevation = Math.min(limit, Math.max(-limit, this.elevation + dy));
    this.changed();
  }

  // By shares of the height of the picture.
  pan(dx, dy) {
    const { right, up } = this.axes();
    const size = 1 / this.share(1);
    const shift = vec.add(vec.scale(right, -dx * size), vec.scale(up, dy * size));
    this.target = vec.add(this.target, shift);
    this.changed();
  }

  zoom(factor) {
    const [low, high] = [1e-3 * this.radius, 30 * this.radius];
    this.distance = Math.min(high, Math.max(low, this.distance * factor));
    this.changed();
  }
}

// Pointers and wheel; a press that does not move is a click.
function followPointers(canvas, camera, clicked) {
  const down = new Map();
  let travelled = 0;
  const spread = () => {
    const [a, b] = [...down.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (down.size === 0) travelled = 0;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (down.size > 1) travelled = Infinity;
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = down.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    const before = down.size === 2 ? spread() : null;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    travelled += Math.hypot(dx, dy);
    const height = canvas.clientHeight;
    if (before) {
      const after = spread();
      camera.pan((after.x - before.x) / height, (after.y - before.y) / height);
      if (after.size > 0) camera.zoom(before.size / after.size);
    } else if (event.shiftKey || event.buttons & 6) {
      camera.pan(dx / height, dy / height);
    } else if (travelled > 4) {
      camera.orbit((dx / height) * 4, (dy / height) * 4);
    }
  });
  const release = (event) => {
    const known = down.delete(event.pointerId);
    if (known && event.type === "pointerup" && travelled <= 4 && event.button === 0) clicked(event);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaMode === 0 ? event.deltaY : 30 * event.deltaY;
    camera.zoom(Math.exp(Math.max(-200, Math.min(200, pixels)) * 0.0015));
  }, { passive: false });
}
