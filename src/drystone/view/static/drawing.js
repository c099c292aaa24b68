// One picture: what is switched on, drawn by the renderer, with names and scales over it.

const COARSE = 0.5; // pixels by those of the screen where pictures come slowly
const PAPER = 700; // [CSS pixels], about the width of a printed page
const IN_PLANE = 1e-3; // by the size of a block: what is so near the section plane lies in it
const MARKER = 6.5; // [CSS pixels], half the size of a marker on large blocks
const PIECES = 16; // of a line whose width changes along it
const MOST_PIECES = 40000; // of all lines of a layer, about
const MANY = 1000; // blocks, from which edges and lines wait where pictures come slowly and move

function sizeOf() {
  return { width: Math.max(1, canvas.clientWidth), height: Math.max(1, canvas.clientHeight) };
}

// What the renderer draws: the eye, and everything that the page has switched on.
function currentView(ratio = window.devicePixelRatio || 1) {
  const { width, height } = sizeOf();
  const colours = Object.fromEntries(
    Object.entries(data.colours[theme()]).map(([role, hex]) => [role, colourOf(hex)]),
  );
  colours.background = colourOf(groundColour());
  const stateColours = new Float32Array(27); // nine states, as in the shaders
  for (const [code, state] of Object.entries(data.states)) {
    stateColours.set(colourOf(state[theme()]), 3 * Number(code));
  }
  const light = theme() === "light";
  const solid = shownLayers.get("blocks") && page.opacity >= 0.5;
  // Small blocks get thin lines, or a large model drowns in them.
  const pixels = camera.share(data.blockSize) * height;
  const time = awayFromRest();
  return {
    ...camera.view(width / height), ratio, colours, stateColours,
    width: Math.round(width * ratio), height: Math.round(height * ratio), // [pixels]
    fine: Math.min(1, Math.max(0.3, pixels / 30)),
    markerSize: Math.min(MARKER, Math.max(2, 0.09 * pixels)),
    time: Math.abs(time) < 1e-9 ? 0 : time,
    spread: camera.spread,
    sectioned: page.section.axis >= 0,
    section: sectionPlane(),
    opacity: page.opacity, selected: page.selected, hovered: page.hovered, joint: page.joint,
    edgeColour: solid && !light ? [0.06, 0.07, 0.08] : colours.edge,
    ghostColour: light ? [0.25, 0.25, 0.25] : [0.8, 0.8, 0.8],
    fallColour: light ? [0.52, 0.13, 0.38] : [0.95, 0.68, 0.85],
    hatch: colourOf(data.states[5][theme()]),
    cut: colours.cut,
    outline: light ? [0.1, 0.12, 0.15] : [1, 1, 1],
    shadow: light ? 0.16 : 0.5,
    ramp: new Float32Array(data.ramp[theme()].flatMap(colourOf)),
    stretch: page.stretch,
    showBlocks: shownLayers.get("blocks"),
    showEdges: shownLayers.get("edges") && !(hurried && !sharp && (bare || data.count >= MANY)),
    hurried, sharp,
    coarse: coarse(),
    showGhost: hasGhost(),
    showGround: shownLayers.get("ground") && !camera.spread,
    layers: drawnLayers().filter((layer) => !waits(layer)),
    metresPerPixel: (2 * camera.distance * SLOPE) / height,
  };
}

const awayFromRest = () => (stage().path ? Number(page.time > 0) : stage().arrives ? 1 - page.time : page.time);

// What is drawn in a view from a direction.
function drawnLayers({ back } = camera.axes()) {
  const drawn = stage().layers.filter((layer) => shown(layer) && isDrawn(layer, awayFromRest()));
  return drawn.map((layer) => (camera.flat && isEdgeOn(layer, back) ? outlineOf(layer) : layer));
}

// What the legend tells of a view from a direction: what it draws.
const told = (axes) => ({
  blocks: shownLayers.get("blocks"), opacity: page.opacity, ghost: hasGhost(), layers: drawnLayers(axes),
});

const hasGhost = () => shownLayers.get("ghost") && Boolean(stage().motion) && !stage().virtual && !camera.spread;

// While blocks move their joints mean nothing; what holds or would hold them stays, and what drives them.
// The forces of a stage that `moved` are those at the end of its motion.
function isDrawn(layer, time) {
  if (stage().moved) {
    if (page.time < 1) return false;
  } else if (time > 0) {
    const stays = ["surface", "tie-forces", "line", "acceleration"].includes(layer.key) && !stage().path;
    return layer.kind === "markers" || layer.colour === "help" || stays;
  }
  return !(camera.spread && layer.kind === "lines" && layer.value); // they would end in the air
}

const outlines = new WeakMap();

// The faces of a layer as the lines around them, drawn over the edges of blocks. Where a value differs
// within a face its lines are in pieces, so that they grow wider with it.
function outlineOf(layer) {
  if (outlines.has(layer)) return outlines.get(layer);
  const { position, value, corners } = layer;
  const first = starts(corners);
  const [at, vector, values, joints] = [[], [], [], []];
  const most = Math.max(1, Math.min(PIECES, Math.round(MOST_PIECES / (position.length / 3))));
  corners.forEach((count, face) => {
    for (let i = 0; i < count; i++) {
      const [from, to] = [i, (i + 1) % count].map((k) => first[face] + k);
      const [start, end] = [from, to].map((k) => position.subarray(3 * k, 3 * k + 3));
      const rise = value ? value[to] - value[from] : 0;
      const pieces = rise === 0 ? 1 : most;
      const part = vec.scale(vec.sub(end, start), 1 / pieces);
      for (let k = 0; k < pieces; k++) {
        at.push(...vec.add(start, vec.scale(part, k)));
        vector.push(...part);
        if (value) values.push(value[from] + (rise * (k + 0.5)) / pieces);
        joints.push(layer.interface?.[face]);
      }
    }
  });
  const made = {
    ...layer, kind: "lines", over: true, width: value ? 1 : 2, interface: layer.interface && joints,
    position: Float32Array.from(at), vector: Float32Array.from(vector), value: value && Float32Array.from(values),
  };
  outlines.set(layer, made);
  return made;
}

// Whether a parallel view looks along all faces of a layer: none is seen, as of the joints of a plane arch.
function isEdgeOn({ kind, position, corners }, back) {
  if (kind !== "polygons") return false;
  const at = (corner) => position.subarray(3 * corner, 3 * corner + 3);
  const first = starts(corners);
  for (let face = 0; face < corners.length; face++) {
    for (let i = first[face] + 1; i + 1 < first[face + 1]; i++) {
      const [p, q] = [i, i + 1].map((corner) => vec.sub(at(corner), at(first[face])));
      const normal = vec.cross(p, q);
      if (Math.abs(vec.dot(normal, back)) > IN_PLANE * vec.length(normal)) return false;
    }
  }
  return true;
}

// While pictures of many blocks come slowly, lines wait, unless they are fewer than the blocks.
function waits(layer) {
  const many = data.count >= MANY && layer.position.length >= 3 * data.count;
  return hurried && (layer.kind === "polygons" ? bare : coarse() && many);
}

// What lies between the plane and the eye is not drawn; the side is that of the eye at first.
function sectionPlane() {
  const { axis, at, side } = page.section;
  const plane = [0, 0, 0, 1];
  if (axis < 0) return plane;
  plane[axis] = side;
  plane[3] = side * at * data.half[axis] + IN_PLANE * data.blockSize;
  return plane;
}

function setSection(axis, at, side = camera.axes().back[axis] < 0 ? -1 : 1) {
  page.section = { axis, at, side: axis < 0 ? 1 : side };
  byId("section-axis").value = axis < 0 ? "" : axis;
  byId("section").value = at;
  byId("section").disabled = axis < 0;
  redraw();
}

function resized(target, { width, height }) {
  if (target.width !== width || target.height !== height) Object.assign(target, { width, height });
}

// Whether what moves is drawn with fewer pixels, without what is inside of the blocks.
const coarse = () => hurried && (cost === 0 || cost > SLOW);

function viewNow() {
  return currentView((coarse() && !sharp ? COARSE : 1) * (window.devicePixelRatio || 1));
}

function draw() {
  const view = viewNow();
  resized(canvas, view);
  renderer.draw(view);
  drawOver(view);
}

// The whole picture in steps; on the canvas when all are done.
function * drawSteps() {
  const view = viewNow();
  yield* renderer.whole(view);
  resized(canvas, view);
  renderer.showSheet();
  drawOver(view);
}

// What is written over the picture, and beside it.
function drawOver(view) {
  if (byId("legend").dataset.told !== keysOf(told())) showLegend(data, stage(), theme(), told());
  byId("drawing").hidden = view.layers.length === drawnLayers().length; // else some wait
  const ratio = window.devicePixelRatio || 1;
  const { width, height } = sizeOf();
  const marks = byId("marks");
  resized(marks, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  drawMarks(marks.getContext("2d"), view, ratio);
}

// The ground of the page: that of the system where it forces its colours.
function groundColour() {
  const own = data.colours[theme()].background;
  if (!forcing.matches || page.printing) return own;
  const parts = getComputedStyle(document.body).backgroundColor.match(/\d+/g) ?? [];
  return parts.length < 3
    ? own : `#${parts.slice(0, 3).map((x) => Number(x).toString(16).padStart(2, "0")).join("")}`;
}

function markColours() {
  const light = theme() === "light";
  const roles = data.colours[theme()];
  return {
    ink: light ? "#1d1b18" : "#eceae5", paper: groundColour(), accent: roles.pressure,
    kern: roles.kern, network: roles.network,
    x: light ? "#b3343c" : "#ff8d94", y: light ? "#2e7d32" : "#8fd694", z: light ? "#2b5fb4" : "#9cc3ff",
  };
}

// On paper the picture is made smaller, and its marks are drawn larger by as much.
const markSize = () => (page.printing ? Math.max(1, sizeOf().width / PAPER) : 1);

function drawMarks(pen, seen, ratio) {
  const whole = sizeOf();
  const grown = markSize();
  const size = { width: whole.width / grown, height: whole.height / grown };
  const view = { ...seen, metresPerPixel: seen.metresPerPixel * grown };
  const colours = markColours();
  pen.setTransform(ratio * grown, 0, 0, ratio * grown, 0, 0);
  pen.clearRect(0, 0, size.width, size.height);
  const names = shownLayers.get("names");
  const numbers = shownLayers.get("numbers");
  if (view.time === 0) {
    drawLabels(pen, blockLabels(data, stage(), view, size, { names, numbers, hidden: page.hidden }), colours);
  }
  if (page.joint >= 0 && view.time === 0) drawJoint(pen, data, stage(), page.joint, view, size, colours);
  if (page.measuring?.length) drawMeasure(pen, page.measuring, view, size, colours);
  drawScale(pen, view, size, colours);
  drawGizmo(pen, view, stage().gravity, size, colours);
}
