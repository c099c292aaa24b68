// Puts the parts together: state of the page, controls, keys, drawing when something changed.

const FALL_SECONDS = 2.4;
const STAGE_SECONDS = 0.9;
const SLOW = 100; // [ms] from asking for a picture to drawing it: leave the edges out meanwhile
const SETTLE = 250; // [ms] without a change: draw everything

const byId = (id) => document.getElementById(id);
const canvas = byId("view");
const data = readData();
const darkness = matchMedia("(prefers-color-scheme: dark)");
const shownLayers = new Map([["blocks", true], ["edges", true]]);
for (const stage of data.stages) {
  for (const layer of stage.layers) {
    if (!shownLayers.has(layer.key)) shownLayers.set(layer.key, layer.visible);
  }
}

let stageNumber = 0;
let selected = -1;
let time = 0;
let opacity = 1;
let arrowScale = 0; // decimal logarithm
let waiting = false;
let hurried = false; // pictures come slowly
let settling = 0;
let animation = null; // { kind, start }
let renderer = null;

const stage = () => data.stages[stageNumber];
const theme = () => (darkness.matches ? "dark" : "light");
const shown = (layer) => shownLayers.get(layer.key);

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
    draw();
  });
}

function settle() {
  hurried = false;
  draw();
}

const camera = new Camera(data.half, data.toward, redraw);

function currentView() {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const roles = data.colours[theme()];
  const colours = Object.fromEntries(
    Object.entries(roles).map(([role, hex]) => [role, colourOf(hex)]),
  );
  const stateColours = new Float32Array(24);
  for (const [code, state] of Object.entries(data.states)) {
    stateColours.set(colourOf(state[theme()]), 3 * Number(code));
  }
  // Lines alone are read against the background, lines on blocks against the blocks.
  const lines = shownLayers.get("blocks") && opacity >= 0.5;
  const edgeColour = lines || theme() === "light" ? colours.edge : [0.66, 0.66, 0.66];
  // Small blocks get thin lines, or a large model drowns in them.
  const pixels = camera.share(data.blockSize) * canvas.clientHeight;
  const fine = Math.min(1, Math.max(0.25, pixels / 24));
  return {
    ...camera.view(width / height), ratio, fine, time, opacity, selected, colours, stateColours,
    edgeColour,
    scale: data.forceScale * 10 ** arrowScale,
    showBlocks: shownLayers.get("blocks"),
    showEdges: shownLayers.get("edges") && !(hurried && shownLayers.get("blocks")),
    layers: stage().layers.filter(shown),
  };
}

function draw() {
  if (renderer && !renderer.gl.isContextLost()) renderer.draw(currentView());
}

// Moves what is being played; free fall starts slowly.
function advance(now) {
  if (!animation) return;
  animation.start ??= now;
  const seconds = (now - animation.start) / 1000;
  if (animation.kind === "motion") {
    const share = Math.min(1, seconds / FALL_SECONDS);
    setTime(share * share);
    if (share === 1) stop();
  } else {
    const next = Math.floor(seconds / STAGE_SECONDS);
    setStage(Math.min(next, data.stages.length - 1));
    if (next >= data.stages.length - 1) stop();
  }
  if (animation) redraw();
}

function stop() {
  animation = null;
  byId("play").textContent = "Play";
  byId("stage-play").textContent = "Play";
}

function play(kind) {
  const again = animation?.kind !== kind;
  stop();
  if (!again || (kind === "motion" && !stage().motion)) return;
  animation = { kind, start: null };
  byId(kind === "motion" ? "play" : "stage-play").textContent = "Stop";
  redraw();
}

function setTime(value) {
  time = value;
  byId("motion").value = value;
  redraw();
}

function setStage(number) {
  stageNumber = number;
  if (!stage().motion) time = 0;
  renderer?.setStage(stage());
  byId("stage").value = number;
  byId("stage-label").textContent = `${number + 1} of ${data.stages.length}: ${stage().label}`;
  byId("motion-box").hidden = !stage().motion;
  byId("scale-box").hidden = !stage().layers.some((layer) => layer.kind === "arrows");
  showVerdict(stage());
  refreshPanels();
}

function refreshPanels() {
  showLegend(data, stage(), theme(), shown);
  showLayers(stage(), theme(), data, shown, (key, on) => {
    shownLayers.set(key, on);
    showLegend(data, stage(), theme(), shown);
    redraw();
  });
  showBlock(data, stage(), selected, select);
  redraw();
}

function select(block) {
  selected = block;
  showBlock(data, stage(), block, select);
  byId("name").value = block < 0 ? "" : data.blocks.names[block];
  redraw();
}

function blockAt(event) {
  if (!renderer || !shownLayers.get("blocks")) return -1;
  const box = canvas.getBoundingClientRect();
  const view = currentView();
  const x = Math.floor((event.clientX - box.left) * view.ratio);
  const y = canvas.height - 1 - Math.floor((event.clientY - box.top) * view.ratio);
  return renderer.pick(x, y, view);
}

function centreOn(block) {
  if (block < 0) return;
  camera.target = Array.from(data.blocks.centroid.subarray(3 * block, 3 * block + 3));
  redraw();
}

function find(text) {
  const { names } = data.blocks;
  const wanted = text.trim();
  if (wanted === "") return select(-1);
  let block = names.indexOf(wanted);
  if (block < 0) block = names.findIndex((name) => name.toLowerCase() === wanted.toLowerCase());
  if (block < 0) {
    byId("block").replaceChildren(element("p", `no block is called \u201c${wanted}\u201d`));
    return undefined;
  }
  select(block);
  return centreOn(block);
}

const aspect = () => canvas.clientWidth / Math.max(1, canvas.clientHeight);
const fit = (azimuth, elevation) => camera.fit(azimuth, elevation, aspect());

const KEYS = {
  ArrowLeft: (shift) => (shift ? camera.pan(0.05, 0) : camera.orbit(0.08, 0)),
  ArrowRight: (shift) => (shift ? camera.pan(-0.05, 0) : camera.orbit(-0.08, 0)),
  ArrowUp: (shift) => (shift ? camera.pan(0, 0.05) : camera.orbit(0, 0.08)),
  ArrowDown: (shift) => (shift ? camera.pan(0, -0.05) : camera.orbit(0, -0.08)),
  "+": () => camera.zoom(0.88),
  "=": () => camera.zoom(0.88),
  "-": () => camera.zoom(1 / 0.88),
  f: () => fit(),
  p: () => play("motion"),
  ",": () => select((selected <= 0 ? data.count : selected) - 1),
  ".": () => select((selected + 1) % data.count),
  Escape: () => select(-1),
};

function connect() {
  followPointers(canvas, camera, (event) => select(blockAt(event)));
  canvas.addEventListener("dblclick", (event) => centreOn(blockAt(event)));
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in KEYS)) return;
    KEYS[event.key](event.shiftKey);
    event.preventDefault();
  });
  byId("opacity").addEventListener("input", (event) => {
    opacity = Number(event.target.value);
    redraw();
  });
  byId("scale").addEventListener("input", (event) => {
    arrowScale = Number(event.target.value);
    redraw();
  });
  byId("motion").addEventListener("input", (event) => {
    stop();
    setTime(Number(event.target.value));
  });
  byId("play").addEventListener("click", () => play("motion"));
  byId("stage").addEventListener("input", (event) => {
    stop();
    setStage(Number(event.target.value));
  });
  byId("stage-play").addEventListener("click", () => play("stages"));
  byId("fit").addEventListener("click", () => fit());
  byId("front").addEventListener("click", () => fit(-Math.PI / 2, 0));
  byId("side").addEventListener("click", () => fit(0, 0));
  byId("top").addEventListener("click", () => fit(-Math.PI / 2, Math.PI / 2 - 1e-4));
  byId("find").addEventListener("submit", (event) => {
    event.preventDefault();
    find(byId("name").value);
  });
  byId("fold").addEventListener("click", () => {
    const open = byId("fold").getAttribute("aria-expanded") === "true";
    byId("fold").setAttribute("aria-expanded", String(!open));
  });
  new ResizeObserver(redraw).observe(canvas);
  window.addEventListener("resize", redraw); // a new pixel ratio
  darkness.addEventListener("change", refreshPanels);
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => {
    renderer.build();
    redraw();
  });
}

try {
  renderer = new Renderer(canvas, data);
} catch (error) {
  const trouble = byId("trouble");
  trouble.hidden = false;
  trouble.textContent = error.message === "no WebGL2"
    ? "This browser cannot draw the model: it has no WebGL2, or it is switched off. "
      + "The verdict and the blocks can still be read here."
    : `The model could not be drawn: ${error.message}`;
}
byId("stage-box").hidden = data.stages.length < 2;
byId("stage").max = data.stages.length - 1;
if (matchMedia("(max-width: 720px)").matches) byId("fold").setAttribute("aria-expanded", "false");
connect();
setStage(0);
fit();
