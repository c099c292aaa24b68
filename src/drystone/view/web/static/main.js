// Puts the parts together: state of the page, controls, keys, drawing when something changed.

const FALL_SECONDS = 2.4;
const STAGE_SECONDS = 1.6;
const SLOW = 100; // [ms] from asking for a picture to drawing it: draw coarsely meanwhile
const COARSE = 0.5; // pixels by those of the screen where pictures come slowly
const MANY = 3000; // blocks, from which lines wait where pictures come slowly
const SETTLE = 250; // [ms] without a change: draw everything
const NEAR_JOINT = 11; // [CSS pixels] from the middle of a joint: it is meant
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

const camera = new Camera(allPlaces(), data.half, data.toward, redraw);

// Corners of all blocks, and where blocks come from that are moved into their places.
function allPlaces() {
  const { point, centroid } = data.blocks;
  const places = Array.from(thinned(point));
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

function sizeOf() {
  return { width: Math.max(1, canvas.clientWidth), height: Math.max(1, canvas.clientHeight) };
}

// What the renderer draws: the eye, and everything that the page has switched on.
function currentView(ratio = window.devicePixelRatio || 1) {
  const { width, height } = sizeOf();
  const colours = Object.fromEntries(
    Object.entries(data.colours[theme()]).map(([role, hex]) => [role, colourOf(hex)]),
  );
  const stateColours = new Float32Array(24);
  for (const [code, state] of Object.entries(data.states)) {
    stateColours.set(colourOf(state[theme()]), 3 * Number(code));
  }
  const light = theme() === "light";
  const solid = shownLayers.get("blocks") && page.opacity >= 0.5;
  // Small blocks get thin lines, or a large model drowns in them.
  const pixels = camera.share(data.blockSize) * height;
  const time = stage().arrives ? 1 - page.time : page.time;
  const layers = stage().layers.filter(shown);
  return {
    ...camera.view(width / height), ratio, colours, stateColours,
    fine: Math.min(1, Math.max(0.3, pixels / 30)),
    markerSize: Math.min(MARKER, Math.max(2, 0.09 * pixels)),
    time: Math.abs(time) < 1e-9 ? 0 : time,
    spread: camera.spread,
    anchor: [0, 0, -data.half[2]],
    sectioned: page.section.axis >= 0,
    section: sectionPlane(),
    opacity: page.opacity, selected: page.selected, hovered: page.hovered, joint: page.joint,
    edgeColour: solid && !light ? [0.06, 0.07, 0.08] : colours.edge,
    ghostColour: light ? [0.25, 0.25, 0.25] : [0.8, 0.8, 0.8],
    fallColour: light ? [0.52, 0.13, 0.38] : [0.95, 0.68, 0.85],
    hatch: colourOf(data.states[5][theme()]),
    cut: light ? [0.45, 0.43, 0.4] : [0.62, 0.6, 0.56],
    outline: light ? [0.1, 0.12, 0.15] : [1, 1, 1],
    shadow: light ? 0.16 : 0.5,
    ramp: new Float32Array(data.ramp[theme()].flatMap(colourOf)),
    stretch: page.stretch,
    showBlocks: shownLayers.get("blocks"),
    showEdges: shownLayers.get("edges") && !hurried,
    hurried,
    showGhost: shownLayers.get("ghost") && Boolean(stage().motion) && !camera.spread,
    showGround: shownLayers.get("ground") && !camera.spread,
    layers: layers.filter((layer) => isDrawn(layer, time)),
    metresPerPixel: (2 * camera.distance * SLOPE) / height,
  };
}

// While blocks move their joints mean nothing; while pictures of many blocks come slowly, lines wait.
function isDrawn(layer, time) {
  if (time > 0) return layer.kind === "markers";
  return !hurried || data.count < MANY || layer.kind === "polygons";
}

function sectionPlane() {
  const { axis, at } = page.section;
  const plane = [0, 0, 0, 1];
  if (axis < 0) return plane;
  plane[axis] = 1;
  plane[3] = at * data.half[axis];
  return plane;
}

function resized(target, ratio) {
  const { width, height } = sizeOf();
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (target.width !== w || target.height !== h) [target.width, target.height] = [w, h];
}

function draw() {
  if (!renderer || renderer.gl.isContextLost()) return;
  const ratio = window.devicePixelRatio || 1;
  const coarse = hurried ? COARSE * ratio : ratio;
  resized(canvas, coarse);
  const view = currentView(coarse);
  renderer.draw(view);
  const marks = byId("marks");
  resized(marks, ratio);
  drawMarks(marks.getContext("2d"), view, ratio);
}

function markColours() {
  const light = theme() === "light";
  const roles = data.colours[theme()];
  return {
    ink: light ? "#1d1b18" : "#eceae5", paper: roles.background, accent: roles.pressure,
    kern: roles.kern, network: roles.network,
    x: light ? "#b3343c" : "#ff8d94", y: light ? "#2e7d32" : "#8fd694", z: light ? "#2b5fb4" : "#9cc3ff",
  };
}

function drawMarks(pen, view, ratio) {
  const size = sizeOf();
  const colours = markColours();
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, size.width, size.height);
  const names = shownLayers.get("names");
  const numbers = shownLayers.get("numbers");
  if ((names || numbers) && view.time === 0) {
    drawLabels(pen, blockLabels(data, stage(), view, size, { names, numbers, hidden: page.hidden }), colours);
  }
  if (page.joint >= 0 && view.time === 0) drawJoint(pen, data, stage(), page.joint, view, size, colours);
  if (page.measuring?.length) drawMeasure(pen, page.measuring, view, size, colours);
  drawScale(pen, view, size, colours);
  drawGizmo(pen, view, stage().gravity, size, colours);
}

// Moves what is being played; free fall starts slowly.
function advance(now) {
  if (!animation) return;
  animation.start ??= now;
  const seconds = (now - animation.start) / 1000;
  if (animation.kind === "motion") {
    const share = Math.min(1, seconds / FALL_SECONDS);
    setTime(stage().arrives ? share * (2 - share) : share * share);
    if (share === 1) stop();
  } else {
    const next = animation.first + Math.floor(seconds / STAGE_SECONDS);
    const last = data.stages.length - 1;
    if (Math.min(next, last) !== page.stage) setStage(Math.min(next, last));
    if (stage().arrives) {
      const share = Math.min(1, (2 * (seconds % STAGE_SECONDS)) / STAGE_SECONDS);
      setTime(next > last ? 1 : share * (2 - share));
    }
    if (next > last) stop();
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
  const first = page.stage >= data.stages.length - 1 ? 0 : page.stage;
  animation = { kind, start: null, first };
  byId(kind === "motion" ? "play" : "stage-play").textContent = "Stop";
  redraw();
}

function setTime(value) {
  page.time = value;
  byId("motion").value = value;
  redraw();
}

function setStage(number) {
  const before = page.stage;
  page.stage = Math.min(data.stages.length - 1, Math.max(0, number));
  setTime(inPlace());
  // What falls has no forces to show: it is solid, and plays once.
  const due = stage().plays ? "solid" : "forces";
  if (page.wanted === "forces" && page.preset !== due) applyPreset(due);
  if (before !== page.stage && stage().plays && !still.matches && !animation) play("motion");
  renderer?.setStage(stage(), page.hidden);
  camera.upward = stage().up;
  byId("stage").value = page.stage;
  byId("stage-label").textContent = `${page.stage + 1} of ${data.stages.length}: ${stage().label}`;
  byId("motion-box").hidden = !stage().motion;
  byId("motion-name").textContent = stage().motionName;
  byId("scale-box").hidden = !stage().layers.some((layer) => layer.kind === "arrows");
  showHeader(data, stage());
  showWorst(data, stage(), actions);
  refreshPanels();
}

function refreshPanels() {
  showLegend(data, stage(), theme(), shown);
  showLayers(stage(), theme(), data, shown, (key, on) => {
    shownLayers.set(key, on);
    showLegend(data, stage(), theme(), shown);
    redraw();
  });
  refreshCard();
}

function refreshCard() {
  const card = byId("card");
  card.replaceChildren();
  if (page.joint >= 0) card.append(showJoint(data, stage(), page.joint, actions));
  else if (page.selected >= 0) card.append(showBlock(data, stage(), page.selected, actions));
  redraw();
}

// A picture with a name; what no preset names keeps its own setting.
function choosePreset(key) {
  page.wanted = key;
  applyPreset(key);
  refreshPanels();
}

function applyPreset(key) {
  const preset = data.presets[key];
  page.preset = key;
  for (const layer of data.stages.flatMap((one) => one.layers)) {
    shownLayers.set(layer.key, known.has(layer.key) ? preset.layers.includes(layer.key) : layer.visible);
  }
  shownLayers.set("blocks", true);
  shownLayers.set("edges", true);
  shownLayers.set("ground", shownLayers.get("ground") ?? true);
  shownLayers.set("names", shownLayers.get("names") ?? false);
  shownLayers.set("numbers", preset.numbers);
  shownLayers.set("ghost", preset.ghost);
  page.opacity = preset.opacity;
  byId("opacity").value = preset.opacity;
  for (const one of byId("presets").children) {
    one.setAttribute("aria-pressed", String(one.dataset.preset === key));
  }
}

function presetButtons() {
  const layers = new Set(data.stages.flatMap((one) => one.layers.map((layer) => layer.key)));
  for (const [key, { label }] of Object.entries(data.presets)) {
    const made = button(label, () => choosePreset(key), { "data-preset": key, "aria-pressed": "false" });
    made.disabled = (key === "forces" && !layers.has("network"))
      || (key === "utilisation" && !layers.has("joint-use"))
      || (key === "contacts" && !layers.has("interfaces"))
      || (key === "stages" && data.stages.length < 2);
    byId("presets").append(made);
  }
}

const actions = {
  select(block) {
    [page.selected, page.joint] = [block, -1];
    byId("matches").replaceChildren();
    refreshCard();
  },
  selectJoint(joint) {
    [page.selected, page.joint] = [-1, joint];
    refreshCard();
  },
  hide(block) {
    page.hidden.add(block);
    changeHidden();
  },
  // A block and those that touch it.
  isolate(block) {
    const { a, b } = data.contacts;
    const kept = new Set([block]);
    for (const i of data.interfacesOf[block]) kept.add(a[i] === block ? b[i] : a[i]);
    page.hidden = new Set(Array.from({ length: data.count }, (_, i) => i).filter((i) => !kept.has(i)));
    changeHidden();
  },
  showAll() {
    page.hidden.clear();
    changeHidden();
  },
};

function changeHidden() {
  renderer?.setStage(stage(), page.hidden);
  byId("all").hidden = page.hidden.size === 0;
  byId("all").textContent = `Show ${page.hidden.size} hidden`;
  if (page.hidden.has(page.selected)) actions.select(-1);
  redraw();
}

// What lies under the pointer: { block } or { joint } or nothing.
function under(event) {
  if (!renderer) return {};
  const box = canvas.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const view = currentView(canvas.width / Math.max(1, canvas.clientWidth));
  const polygons = view.time === 0 ? view.layers.filter((layer) => layer.kind === "polygons") : [];
  const joint = polygons.some((layer) => layer.interface) ? jointNear(x, y, view) : -1;
  if (joint >= 0) return { joint };
  const row = canvas.height - 1 - Math.floor(y * view.ratio);
  const found = renderer.pick(Math.floor(x * view.ratio), row, view, page.opacity < 1 ? polygons : []);
  if (found === 0) return {};
  return found <= data.count ? { block: found - 1 } : { joint: found - 1 - data.count };
}

// The joint whose middle is nearest to a place of the picture, -1 where none is near.
function jointNear(x, y, view) {
  if (page.opacity >= 1) return -1;
  const { a, b, centroid } = data.contacts;
  const [middle, size] = [data.blocks.centroid, sizeOf()];
  let [best, joint] = [NEAR_JOINT ** 2, -1];
  for (let i = 0; i < a.length; i++) {
    if (page.hidden.has(a[i]) || page.hidden.has(b[i])) continue;
    const p = [0, 1, 2].map((k) => centroid[3 * i + k] + view.spread
      * (0.5 * (middle[3 * a[i] + k] + middle[3 * b[i] + k]) - view.anchor[k]));
    const at = projected(view.projection, p, size.width, size.height);
    if (!at) continue;
    const distance = (at.x - x) ** 2 + (at.y - y) ** 2;
    if (distance < best) [best, joint] = [distance, i];
  }
  return joint;
}

function clicked(event) {
  if (page.measuring) return measureAt(event);
  const { block, joint } = under(event);
  if (joint !== undefined) actions.selectJoint(joint);
  else actions.select(block ?? -1);
  return undefined;
}

function hovered(event) {
  const tip = byId("tip");
  const found = event ? under(event) : {};
  const before = page.hovered;
  page.hovered = found.block ?? -1;
  if (before !== page.hovered) redraw();
  tip.hidden = found.block === undefined && found.joint === undefined;
  if (tip.hidden) return;
  tip.textContent = tipText(found);
  const box = canvas.getBoundingClientRect();
  const left = event.clientX - box.left + 14;
  tip.style.left = `${Math.max(0, Math.min(left, box.width - tip.offsetWidth - 4))}px`;
  tip.style.top = `${Math.min(event.clientY - box.top + 14, box.height - tip.offsetHeight - 4)}px`;
}

function tipText({ block, joint }) {
  const { normal, utilisation, state } = stage();
  if (joint !== undefined) {
    const name = jointName(data, joint);
    if (!normal) return `${name}: ${plain(data.contacts.area[joint], "m\u00b2")}`;
    return `${name}: ${quantity(normal[joint], "N")}, ${percent(utilisation[joint])} of friction`;
  }
  const { names, mass, number } = data.blocks;
  const order = number[block] > 0 ? `${number[block]}: ` : "";
  return `${order}${names[block]}, ${data.states[state[block]]?.label ?? ""}, ${plain(mass[block], "kg")}`;
}

// Snaps to the nearest corner of a block that is shown.
function measureAt(event) {
  const box = canvas.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const [view, size] = [currentView(), sizeOf()];
  const { point, points } = data.blocks;
  let best = { value: Infinity };
  let p = 0;
  for (let block = 0; block < data.count; block++) {
    for (let k = 0; k < points[block]; k++, p += 3) {
      if (stage().state[block] === 0 || page.hidden.has(block)) continue;
      const corner = point.subarray(p, p + 3);
      const at = projected(view.projection, corner, size.width, size.height);
      if (!at) continue;
      const away = Math.hypot(at.x - x, at.y - y);
      if (away < 24 && away + 200 * at.depth < best.value) best = { value: away + 200 * at.depth, corner };
    }
  }
  if (!best.corner) return say("no corner of a block is near");
  if (page.measuring.length >= 2) page.measuring = [];
  page.measuring.push(Array.from(best.corner));
  if (page.measuring.length === 2) {
    const d = vec.sub(page.measuring[1], page.measuring[0]);
    const parts = d.map((v, i) => `${"xyz"[i]} ${plain(Math.abs(v), "m")}`).join(", ");
    say(`${plain(vec.length(d), "m")} (${parts})`);
  } else say("click the second corner");
  return redraw();
}

function say(text) {
  byId("measured").textContent = text;
  byId("said").textContent = text;
}

function centreOn(block) {
  if (block === undefined || block < 0) return;
  const { azimuth, elevation } = camera;
  const target = Array.from(data.blocks.centroid.subarray(3 * block, 3 * block + 3));
  camera.go({ azimuth, elevation, target, distance: camera.distance }, flightTime());
}

function showMatches(text) {
  const box = byId("matches");
  box.replaceChildren();
  if (text.trim() === "") return [];
  const { blocks, total } = matches(data.blocks.names, text.trim());
  for (const block of blocks) {
    box.append(button(data.blocks.names[block], () => {
      actions.select(block);
      centreOn(block);
    }));
  }
  if (total === 0) box.append(element("p", `no block has \u201c${text.trim()}\u201d in its name`));
  if (total > blocks.length) box.append(element("p", `and ${total - blocks.length} more`));
  return blocks;
}

function find(text) {
  if (text.trim() === "") return actions.select(-1);
  const [block] = showMatches(text);
  if (block === undefined) return undefined;
  actions.select(block);
  return centreOn(block);
}

const flightTime = () => (still.matches ? 0 : FLIGHT);

// What the texts over the picture leave free, as shares of it: left, right, top, bottom.
function insets() {
  const { width, height } = sizeOf();
  const shareOf = (id) => byId(id).offsetHeight / height;
  const top = Math.min(0.3, shareOf("verdict") + 8 / height);
  const legend = byId("legend");
  const beside = legend.offsetWidth < 0.3 * width;
  const bottom = beside ? 64 / height : Math.min(0.35, shareOf("legend") + 8 / height);
  const left = beside ? (legend.offsetWidth + 8) / width : 16 / width;
  return { left, right: Math.max(24, beside ? 40 : 24) / width, top, bottom };
}

function fit(azimuth = camera.azimuth, elevation = camera.elevation, soon = flightTime()) {
  const { width, height } = sizeOf();
  camera.go(camera.fitted(azimuth, elevation, width / height, insets()), soon);
}

// Straight views are parallel projections, as on a drawing.
function look(azimuth, elevation) {
  camera.flat = true;
  fit(azimuth, elevation);
}

const KEYS = {
  ArrowLeft: (shift) => (shift ? camera.pan(0.05, 0) : camera.orbit(0.08, 0)),
  ArrowRight: (shift) => (shift ? camera.pan(-0.05, 0) : camera.orbit(-0.08, 0)),
  ArrowUp: (shift) => (shift ? camera.pan(0, 0.05) : camera.orbit(0, 0.08)),
  ArrowDown: (shift) => (shift ? camera.pan(0, -0.05) : camera.orbit(0, -0.08)),
  "+": () => camera.zoom(0.88),
  "=": () => camera.zoom(0.88),
  "-": () => camera.zoom(1 / 0.88),
  f: () => fitAll(),
  1: () => look(-Math.PI / 2, 0),
  2: () => look(0, 0),
  3: () => look(-Math.PI / 2, VERTICAL),
  p: () => play(stage().motion ? "motion" : "stages"),
  PageDown: () => stepStage(1),
  PageUp: () => stepStage(-1),
  ",": () => actions.select((page.selected <= 0 ? data.count : page.selected) - 1),
  ".": () => actions.select((page.selected + 1) % data.count),
  h: () => page.selected >= 0 && actions.hide(page.selected),
  i: () => page.selected >= 0 && actions.isolate(page.selected),
  a: () => actions.showAll(),
  Escape: () => {
    setMeasuring(false);
    actions.select(-1);
  },
};

function fitAll() {
  camera.flat = false;
  fit();
}

function stepStage(by) {
  stop();
  setStage(page.stage + by);
}

function setMeasuring(on) {
  page.measuring = on ? [] : null;
  byId("measure").setAttribute("aria-pressed", String(on));
  say(on ? "click two corners of blocks" : "");
  redraw();
}

// The view as text for the end of an address, and back.
function viewText() {
  const { azimuth, elevation, distance, target, flat } = camera;
  const numbers = [azimuth, elevation, distance, ...target].map((x) => Number(x.toPrecision(6)));
  const parts = { v: numbers.join(","), p: page.preset, s: page.stage, o: page.opacity };
  if (flat) parts.f = 1;
  if (page.selected >= 0) parts.b = page.selected;
  if (page.joint >= 0) parts.j = page.joint;
  return new URLSearchParams(parts).toString();
}

function readView(text) {
  const parts = new URLSearchParams(text);
  const numbers = (parts.get("v") ?? "").split(",").map(Number);
  if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return false;
  const whole = (key, most) => {
    const value = Number(parts.get(key) ?? -1);
    return Number.isInteger(value) && value >= 0 && value < most ? value : -1;
  };
  if (data.presets[parts.get("p")]) choosePreset(parts.get("p"));
  if (whole("s", data.stages.length) >= 0) setStage(whole("s", data.stages.length));
  const opacity = Number(parts.get("o"));
  if (opacity > 0 && opacity <= 1) page.opacity = opacity;
  camera.flat = parts.get("f") === "1";
  const [azimuth, elevation, distance, ...target] = numbers;
  camera.go({ azimuth, elevation, distance: Math.max(distance, 1e-9), target }, 0);
  if (whole("b", data.count) >= 0) actions.select(whole("b", data.count));
  if (whole("j", data.contacts.a.length) >= 0) actions.selectJoint(whole("j", data.contacts.a.length));
  return true;
}

// The picture, twice as fine as on the screen, with head and legend.
function pictureOf(ratio) {
  const { width, height } = sizeOf();
  const sheet = element("canvas");
  [sheet.width, sheet.height] = [width * ratio, height * ratio];
  const pen = sheet.getContext("2d");
  [canvas.width, canvas.height] = [width * ratio, height * ratio];
  const view = currentView(ratio);
  renderer.draw({ ...view, showEdges: shownLayers.get("edges") });
  pen.drawImage(canvas, 0, 0);
  const marks = element("canvas");
  [marks.width, marks.height] = [sheet.width, sheet.height];
  drawMarks(marks.getContext("2d"), view, ratio);
  pen.drawImage(marks, 0, 0);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { sheet, pen };
}

function exportPng() {
  const { sheet, pen } = pictureOf(2);
  const { width, height } = sizeOf();
  drawTexts(pen, data, stage(), theme(), shown, width, height, markColours().ink);
  sheet.toBlob((blob) => download(fileName(data, "png"), blob), "image/png");
  draw();
}

// A picture in the colours of paper stands in for the canvas while the page is printed.
function beforePrint() {
  if (!renderer) return;
  page.printing = true;
  page.closed = !byId("details").open;
  byId("details").open = true; // paper cannot be clicked
  refreshPanels();
  byId("printed").src = pictureOf(2).sheet.toDataURL("image/png");
  byId("printed").hidden = false;
}

function afterPrint() {
  page.printing = false;
  byId("details").open = !page.closed;
  byId("printed").hidden = true;
  refreshPanels();
}

function connectExports() {
  byId("png").addEventListener("click", exportPng);
  byId("svg").addEventListener("click", () => {
    const text = pictureSvg(data, stage(), currentView(), sizeOf(), theme(), { hidden: page.hidden });
    download(fileName(data, "svg"), text, "image/svg+xml");
  });
  byId("csv").addEventListener("click", () => {
    download(fileName(data, "csv"), jointsCsv(data, stage()), "text/csv");
  });
  byId("link").addEventListener("click", () => {
    const address = byId("address");
    address.value = `${location.href.split("#")[0]}#${viewText()}`;
    address.hidden = false;
    address.select();
    navigator.clipboard?.writeText(address.value).catch(() => {});
  });
  byId("measure").addEventListener("click", () => setMeasuring(page.measuring === null));
  window.addEventListener("beforeprint", beforePrint);
  window.addEventListener("afterprint", afterPrint);
}

function connectSliders() {
  const onInput = (id, change) => byId(id).addEventListener("input", (event) => {
    change(Number(event.target.value));
    redraw();
  });
  onInput("opacity", (value) => { page.opacity = value; });
  onInput("scale", (value) => { page.stretch = 10 ** value; });
  onInput("spread", (value) => { camera.spread = value; });
  onInput("section", (value) => { page.section.at = value; });
  onInput("motion", (value) => {
    stop();
    setTime(value);
  });
  onInput("stage", (value) => {
    stop();
    setStage(value);
  });
  byId("section-axis").addEventListener("change", (event) => {
    page.section.axis = event.target.value === "" ? -1 : Number(event.target.value);
    byId("section").disabled = page.section.axis < 0;
    redraw();
  });
  byId("spread").addEventListener("change", () => fit());
}

function connect() {
  followPointers(canvas, camera, { clicked, hovered });
  canvas.addEventListener("dblclick", (event) => centreOn(under(event).block));
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in KEYS)) return;
    KEYS[event.key](event.shiftKey);
    event.preventDefault();
  });
  connectSliders();
  connectExports();
  const onClick = (id, action) => byId(id).addEventListener("click", action);
  onClick("play", () => play("motion"));
  onClick("stage-play", () => play("stages"));
  onClick("stage-back", () => stepStage(-1));
  onClick("stage-on", () => stepStage(1));
  onClick("fit", fitAll);
  onClick("front", KEYS[1]);
  onClick("side", KEYS[2]);
  onClick("top", KEYS[3]);
  onClick("all", actions.showAll);
  byId("name").addEventListener("input", (event) => showMatches(event.target.value));
  byId("find").addEventListener("submit", (event) => {
    event.preventDefault();
    find(byId("name").value);
  });
  onClick("fold", () => {
    const open = byId("fold").getAttribute("aria-expanded") === "true";
    byId("fold").setAttribute("aria-expanded", String(!open));
  });
  new ResizeObserver(redraw).observe(canvas);
  window.addEventListener("resize", redraw); // a new pixel ratio
  window.addEventListener("hashchange", () => readView(location.hash.slice(1)));
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
if (narrow.matches) byId("fold").setAttribute("aria-expanded", "false");
presetButtons();
connect();
choosePreset(data.preset);
setStage(0);
if (!readView(location.hash.slice(1))) fit(undefined, undefined, 0);
if (stage().plays && !still.matches) setTimeout(() => page.time === inPlace() && play("motion"), 900);
