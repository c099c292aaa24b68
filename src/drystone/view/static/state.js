// What the page shows: its data, its state, and when it is drawn anew.

const SMOOTH = 33; // [ms] that a whole picture takes: above it what moves is drawn coarsely
const SLOW = 100; // [ms] that a whole picture takes: in steps, and what moves with fewer pixels
const VERY_SLOW = 300; // [ms] that coarse pictures take, of which three can be under way: without joints;
// that a whole one takes: it does not follow the pointer
const SETTLE = 120; // [ms] without a change: draw everything
const WAIT = 5; // [ms] between two looks at whether a picture is done
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
  acts: null, // where joints take no clicks, { says, clicked, grabbed } of a block: words, and what is done
};
let waiting = false;
let moves = false; // the picture that is awaited is one of many
let cost = 0; // [ms] that the last whole picture took
let pictures = 0; // drawn so far
let drawnAt = 0; // when the last one was begun
let timed = false; // whether the time of a picture is being taken
let steps = null; // those of a whole picture that is not done
let hurried = false; // pictures come slowly
let sharp = false; // a coarse picture with all pixels and with edges, before a whole one that takes long
let late = 0; // coarse pictures, one after the other, that came slowly
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
    const slow = performance.now() - asked > SLOW && (pictures || data.count >= MANY); // a page opens slowly
    if (slow || (moves && cost > SMOOTH)) hurried = true;
    moves = sharp = false;
    advance(now);
    if (camera.advance(now)) redraw(true);
    drawTimed();
  });
}

// Draws, and learns how long the graphics card, or what stands in for it, takes. A coarse picture
// is drawn anew as a whole once it is done and nothing else was asked for; in steps where a whole one
// takes long, or may, as the first one after coarse ones.
function drawTimed() {
  clearTimeout(settling);
  steps = null;
  if (!renderer || renderer.gl.isContextLost()) return;
  pictures += 1;
  drawnAt = performance.now();
  if (!hurried && (cost > SLOW || (cost === 0 && pictures > 1))) {
    steps = drawSteps();
    drawOn(steps);
    return;
  }
  draw();
  if (!timed) follow();
}

// Learns how long a picture took; when the last one is done, a coarse one is to be drawn as a whole.
async function follow() {
  const [picture, began, whole, rough] = [pictures, drawnAt, !hurried, hurried && !sharp];
  timed = true;
  await drawn();
  timed = false;
  const time = performance.now() - began;
  if (rough && cost > 0) { // while a page opens, everything is slow
    late = time > VERY_SLOW ? late + 1 : 0;
    bare ||= late > 2;
  }
  if (whole) cost = time;
  if (steps) return;
  if (picture !== pictures) follow();
  else if (hurried) settling = setTimeout(settle, sharp ? 0 : SETTLE);
}

// The steps of a whole picture, until another one is asked for.
async function drawOn(mine) {
  while (steps === mine && !waiting) {
    if (mine.next().done) {
      cost = performance.now() - drawnAt;
      steps = null;
    } else await drawn();
  }
}

// Until the graphics card has drawn what it was given.
async function drawn() {
  const { gl } = renderer;
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  do await new Promise((done) => setTimeout(done, WAIT));
  while (!gl.isContextLost() && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED);
  gl.deleteSync(fence);
}

function settle() {
  if (waiting) return;
  const long = hurried && (cost === 0 || cost > VERY_SLOW);
  sharp = long && !sharp && !bare;
  hurried = sharp;
  drawTimed();
}

// Gives up the steps of a picture where something else is drawn between them; it begins anew later.
function interrupt() {
  if (!steps) return;
  steps = null;
  settling = setTimeout(settle, SETTLE);
}

const camera = new Camera(placesAt, data.half, data.toward, () => redraw(true));
