// What the page shows: its data, its state, and when it is drawn anew.

const SLOW = 100; // [ms] from asking for a picture to drawing it: draw coarsely meanwhile
const SETTLE = 250; // [ms] without a change: draw everything
const narrow = matchMedia("(max-width: 720px)");
const still = matchMedia("(prefers-reduced-motion: reduce)");

const byId = (id) => document.getElementById(id);
const canvas = byId("view");
const data = readData();
const forcing = matchMedia("(forced-colors: active)");
const darkness = matchMedia("(prefers-color-scheme: dark)");
const known = new Set(data.known);
const shownLayers = new Map();

const page = {
  stage: 0, preset: "", wanted: "", selected: -1, joint: -1, hovered: -1, time: 0, opacity: 1, stretch: 1,
  hidden: new Set(), section: { axis: -1, at: 0, side: 1 }, measuring: null, printing: false,
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
