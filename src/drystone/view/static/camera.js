// An orbiting eye. `upward` is the direction of the model that points up in the picture; distances
// are in metres from the middle of the model.

const FIELD_OF_VIEW = (28 * Math.PI) / 180;
const SLOPE = Math.tan(FIELD_OF_VIEW / 2);
const FLIGHT = 350; // [ms] from one view to another
const VERTICAL = Math.PI / 2 - 1e-4;

class Camera {
  constructor(placesAt, half, toward, changed) {
    this.placesAt = placesAt; // what is to be seen, by how far the model is taken apart
    this.half = half; // of the sides of the box around the model
    this.radius = Math.max(vec.length(half), 1e-9);
    this.changed = changed;
    this.target = [0, 0, 0];
    this.upward = [0, 0, 1];
    this.azimuth = Math.atan2(toward[1], toward[0]);
    this.elevation = Math.asin(toward[2]);
    this.distance = 1;
    this.flat = false; // parallel projection
    this.flight = null;
    this.fits = ""; // size of the picture that it shows the whole model in, where it was not moved since
    this.spread = 0; // how far the model is taken apart
  }

  // The view that the model fills. Insets are shares of the picture: left, right, top, bottom.
  fitted(azimuth, elevation, aspect, insets) {
    const { right, up, back } = this.axes(azimuth, elevation);
    const points = this.placesAt(this.spread);
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    const bounds = (sx, sy) => {
      const most = { right: -Infinity, left: -Infinity, top: -Infinity, bottom: -Infinity };
      for (let i = 0; i < points.length; i += 3) {
        const p = [points[i], points[i + 1], points[i + 2]];
        const [x, y, z] = [vec.dot(p, right), vec.dot(p, up), vec.dot(p, back)];
        most.right = Math.max(most.right, x + sx[1] * z);
        most.left = Math.max(most.left, -x - sx[0] * z);
        most.top = Math.max(most.top, y + sy[1] * z);
        most.bottom = Math.max(most.bottom, -y - sy[0] * z);
        [low[2], high[2]] = [Math.min(low[2], z), Math.max(high[2], z)];
      }
      return most;
    };
    const [l, r] = [-1 + 2 * insets.left, 1 - 2 * insets.right];
    const [b, t] = [-1 + 2 * insets.bottom, 1 - 2 * insets.top];
    const sx = [l * SLOPE * aspect, r * SLOPE * aspect];
    const sy = [b * SLOPE, t * SLOPE];
    const most = this.flat ? bounds([0, 0], [0, 0]) : bounds(sx, sy);
    const wide = (most.right + most.left) / (sx[1] - sx[0]);
    const high_ = (most.top + most.bottom) / (sy[1] - sy[0]);
    const eye = Math.max(wide, high_, 1e-9); // height of the eye, or distance of a flat view
    const centre = (plus, minus, s) => 0.5 * (plus - s[1] * eye - (minus + s[0] * eye));
    const x = centre(most.right, most.left, sx);
    const y = centre(most.top, most.bottom, sy);
    const depth = 0.5 * (low[2] + high[2]);
    const place = vec.add(vec.add(vec.scale(right, x), vec.scale(up, y)), vec.scale(back, depth));
    return {
      azimuth, elevation, target: place,
      distance: this.flat ? eye : Math.max(eye - depth, 1e-6 * this.radius),
    };
  }

  // Goes to a view; `soon` is the time it takes [ms], 0 for at once.
  go(view, soon = FLIGHT) {
    this.fits = "";
    const to = { ...view };
    to.azimuth = this.azimuth + nearestTurn(to.azimuth - this.azimuth);
    if (soon <= 0) {
      this.flight = null;
      Object.assign(this, to);
    } else {
      const { azimuth, elevation, distance, target } = this;
      this.flight = { from: { azimuth, elevation, distance, target }, to, soon, start: null };
    }
    this.changed();
  }

  // Moves on; whether it is still on its way.
  advance(now) {
    if (!this.flight) return false;
    const { from, to, soon } = this.flight;
    this.flight.start ??= now;
    const share = Math.min(1, (now - this.flight.start) / soon);
    const s = share * share * (3 - 2 * share);
    const mixed = (a, b) => a + (b - a) * s;
    this.azimuth = mixed(from.azimuth, to.azimuth);
    this.elevation = mixed(from.elevation, to.elevation);
    this.distance = from.distance * (to.distance / from.distance) ** s;
    this.target = from.target.map((x, i) => mixed(x, to.target[i]));
    if (share === 1) this.flight = null;
    return this.flight !== null;
  }

  // Unit vectors of the model to the right, up and towards the eye.
  axes(azimuth = this.azimuth, elevation = this.elevation) {
    const [ca, sa] = [Math.cos(azimuth), Math.sin(azimuth)];
    const [ce, se] = [Math.cos(elevation), Math.sin(elevation)];
    const turned = (v) => turnedBetween(v, [0, 0, 1], this.upward);
    return {
      back: turned([ce * ca, ce * sa, se]), right: turned([-sa, ca, 0]),
      up: turned([-se * ca, -se * sa, ce]),
    };
  }

  view(aspect) {
    const { right, up, back } = this.axes();
    const reach = 3 * this.radius * (1 + this.spread); // falling blocks leave the sphere
    const distance = this.flat ? reach + vec.length(this.target) : this.distance;
    const eye = vec.add(this.target, vec.scale(back, distance));
    const middle = vec.dot(eye, back);
    const far = Math.max(middle + reach, 1e-3 * this.radius);
    const near = this.flat
      ? middle - reach : Math.max(middle - reach, 2e-3 * Math.min(this.distance, this.radius));
    const lens = this.flat
      ? parallel(2 * this.distance * SLOPE, aspect, near, far)
      : perspective(FIELD_OF_VIEW, aspect, near, far);
    const light = [0, 1, 2].map((i) => 0.72 * back[i] + 0.42 * up[i] - 0.55 * right[i]);
    const projection = multiply(lens, lookFrom(eye, right, up, back));
    return { projection, back, right, up, light, eye, flat: this.flat };
  }

  // Share of the picture's height that a length at the target takes.
  share(length) {
    return length / (2 * this.distance * SLOPE);
  }

  orbit(dx, dy) {
    [this.flight, this.fits] = [null, ""];
    this.azimuth -= dx;
    this.elevation = Math.min(VERTICAL, Math.max(-VERTICAL, this.elevation + dy));
    this.changed();
  }

  // By shares of the height of the picture.
  pan(dx, dy) {
    [this.flight, this.fits] = [null, ""];
    const { right, up } = this.axes();
    const size = 1 / this.share(1);
    const shift = vec.add(vec.scale(right, -dx * size), vec.scale(up, dy * size));
    this.target = vec.add(this.target, shift);
    this.changed();
  }

  zoom(factor) {
    [this.flight, this.fits] = [null, ""];
    const [low, high] = [1e-3 * this.radius, 30 * this.radius];
    this.distance = Math.min(high, Math.max(low, this.distance * factor));
    this.changed();
  }
}

function nearestTurn(angle) {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}
