// What the page shows: its data, its state, and when it is drawn anew.

const SLOW = 100; // [ms] that a picture takes, or waits: what moves is drawn coarsely
const VERY_SLOW = 300; // [ms] that a coarse picture takes: without joints
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
let moves = false; // the picture that is awaited is one of many
let cost = 0; // [ms] that the last whole picture took
let pictures = 0; // drawn so far
let fence = null; // tells when the picture that is timed is done
let hurried = false; // pictures come slowly
let bare = false; // coarse pictures come slowly, too
let settling = 0;
let animation = null; // { kind, start }
let renderer = null;

const stage = () => data.stages[page.stage];
const theme = () => (darkness.matches && !page.printing ? "dark" : "light");
const shown = (layer) => shownLayers.get(layer.key) ?? false;
const inPlace = () => (stage().arrives ? 1 : 0); // where the motion slider stands at rest

// Asks for a picture; `moving` where many follow each other, as while one turns the model.
function redraw(moving = false) {
  moves ||= moving;
  if (waiting) return;
  waiting = true;
  const asked = performance.now();
  requestAnimationFrame((now) => {
    waiting = false;
    if (performance.now() - asked > SLOW || (moves && cost > SLOW)) hurried = true;
    moves = false;
    clearTimeout(settling);
    advance(now);
    if (camera.advance(now)) redraw(true);
    drawTimed();
  });
}

// Draws, and learns how long the graphics card, or what stands in for it, takes. A coarse picture
// is drawn anew as a whole once it is done and nothing else was asked for.
function drawTimed() {
  draw();
  pictures += 1;
  if (!fence && renderer && !renderer.gl.isContextLost()) follow(pictures, performance.now());
}

function follow(picture, began) {
  const { gl } = renderer;
  fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  const look = () => {
    if (!gl.isContextLost() && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) {
      setTimeout(look, 10);
      return;
    }
    gl.deleteSync(fence);
    fence = null;
    bare ||= hurried && performance.now() - began > VERY_SLOW;
    if (picture !== pictures) follow(pictures, performance.now());
    else if (hurried) settling = setTimeout(settle, SETTLE);
    else cost = performance.now() - began;
  };
  setTimeout(look, 0);
}

function settle() {
  if (waiting) return;
  hurried = false;
  drawTimed();
}

const camera = new Camera(placesAt, data.half, data.toward, () => redraw(true));
