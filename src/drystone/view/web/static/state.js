// What the page shows: its data, its state, and when it is drawn anew.

const SLOW = 100; // [ms] from asking for a picture to drawing it: draw coarsely meanwhile
const SETTLE = 250; // [ms] without a change: draw everything
const narrow = matchMedia("(max-width: 720px)");
const still = matchMedia("(prefers-reduced-motion: reduce)");

const byId = (id) => document.getElementById(id);
const canvas = byId("view");
const data = readData();
const darkness = matchMedia("(prefers-color-scheme: dark)");
const known = new Set(data.known);
const shownLayers = new Map();

const page = {
  stage: 0, preset: "", wanted: "", selected: -1, joint: -1, hovered: -1, time: 0, opacity: 1, stretch: 1,
  hidden: new Set(), section: { axis: -1, at: 0 }, measuring: null, printing: false,
};
let waiting = false;
let hurried = false; // pictures come slowly
let settling = 0;
let animation = null; // { kind, start }
let renderer = null;

const stage = () => data.stages[page.stage];
const theme = () => (darkness.matches && !page.printing ? "dark" : "light");
const shown = (layer) => shownLayers.get(layer.key) ?? false;
const inPlace = () => (stage().arrives ? 1 : 0); // where the motion slider stands at rest

function redraw() {
  if (waiting) return;
  waiting = true;
  const asked = performance.now();
  requestAnimationFrame((now) => {
    waiting = false;
    if (performance.now() - asked > SLOW) hurried = true;
    clearTimeout(settling);
    if (hurried) settling = setTimeout(settle, SETTLE);
    advance(now);
    if (camera.advance(now)) redraw();
    draw();
  });
}

function settle() {
  hurried = false;
  draw();
}

const camera = new Camera(placesAt, data.half, data.toward, redraw);

// Corners of the blocks, every so-many-th where there are many, taken apart by `spread`; and where
// blocks come from that are moved into their places.
function placesAt(spread) {
  const { point, points, centroid, away } = data.blocks;
  const step = Math.max(1, Math.ceil(point.length / 3 / MOST_POINTS));
  const places = [];
  let p = 0;
  for (let block = 0; block < data.count; block++) {
    for (let k = 0; k < points[block]; k++, p++) {
      if (p % step) continue;
      for (let i = 0; i < 3; i++) places.push(point[3 * p + i] + spread * away[3 * block + i]);
    }
  }
  for (const one of data.stages) {
    if (!one.arrives || !one.motion) continue;
    for (let i = 0; i < data.count; i++) {
      const way = one.motion.subarray(6 * i, 6 * i + 3);
      if (vec.length(way) === 0) continue;
      places.push(...vec.add(centroid.subarray(3 * i, 3 * i + 3), vec.scale(way, 1.3)));
    }
  }
  return new Float32Array(places);
}
