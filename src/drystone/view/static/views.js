// Where the page looks from: fitted and straight views, and the view as text.

const NEARLY = 1.06; // a view from so much farther away is as good

const flightTime = () => (still.matches ? 0 : FLIGHT);

// What the texts over the picture leave free, as shares of it: left, right, top, bottom. Where the legend is small
// the model stands above it, or beside it, in the middle or not. On paper all texts are outside.
function insets() {
  const { width, height } = sizeOf();
  const corner = markSize() * CORNER;
  if (page.printing) {
    const [edge, low] = [16, 0.4 * corner]; // below it is the scale
    return [[edge, corner], [corner, low]].map(([right, bottom]) => (
      { left: edge / width, right: right / width, top: edge / height, bottom: bottom / height }));
  }
  const shareOf = (id) => byId(id).offsetHeight / height;
  const top = Math.min(byId("details").open ? 0.6 : 0.3, shareOf("verdict") + 8 / height);
  const legend = byId("legend");
  const below = Math.max(shareOf("legend") + 8 / height, (scaleHeight(width) + 20) / height);
  const above = { left: 16 / width, right: 24 / width, top, bottom: Math.min(0.35, below) };
  if (width <= height || legend.offsetWidth >= 0.3 * width) return [above];
  const beside = (legend.offsetWidth + 8) / width;
  const low = { top, bottom: 64 / height };
  const [wide, narrow] = [40, corner].map((right) => ({ ...above, left: 40 / width, right: right / width }));
  return [
    { ...low, left: beside, right: beside }, { ...wide, bottom: Math.max(wide.bottom, corner / height) }, narrow,
    { ...low, left: beside, right: corner / width },
  ];
}

// The stage, of this one and those in which a block arrives, whose legend has most rows, and what it tells.
function fullest([one, now]) {
  const ghost = shownLayers.get("ghost");
  const others = data.stages.filter(({ arrives, motion }) => arrives && motion)
    .map((other) => [other, theme(), { ...now, ghost, layers: other.layers.filter(shown) }]);
  const rows = (told) => legendRows(data, ...told).length;
  return others.reduce((most, next) => (rows(next) > rows(most) ? next : most), [one, theme(), now]);
}

function fit(azimuth = camera.azimuth, elevation = camera.elevation, soon = flightTime()) {
  const { width, height } = sizeOf();
  const now = told(camera.axes(azimuth, elevation));
  showLegend(data, ...fullest([stage(), now])); // the picture fits above it, at each step
  const views = insets().map((free) => camera.fitted(azimuth, elevation, width / height, free));
  showLegend(data, stage(), theme(), now);
  const least = Math.min(...views.map(({ distance }) => distance));
  camera.go(views.find(({ distance }) => distance <= NEARLY * least), soon);
  camera.fits = `${width},${height}`;
}

// Fits the model anew where it was fitted into a picture of another size.
function refit() {
  const { width, height } = sizeOf();
  if (camera.fits && camera.fits !== `${width},${height}`) fit(camera.azimuth, camera.elevation, 0);
}

// Straight views are parallel projections, as on a drawing.
function look(azimuth, elevation) {
  camera.flat = true;
  fit(azimuth, elevation);
}

function fitAll() {
  camera.flat = data.flat;
  fit();
}

// The view as text for the end of an address, and back: the one that the camera goes to. A view of the
// whole model is that in a window of another size, too.
function viewText() {
  const { azimuth, elevation, distance, target } = camera.flight?.to ?? camera;
  const numbers = [azimuth, elevation, distance, ...target].map((x) => Number(x.toPrecision(6)));
  const parts = { v: numbers.join(","), p: page.preset, s: page.stage };
  if (page.opacity !== data.presets[page.preset].opacity) parts.o = page.opacity;
  if (camera.flat) parts.f = 1;
  if (camera.fits) parts.a = camera.fits;
  const { axis, at, side } = page.section;
  if (axis >= 0) parts.x = [axis, at, side].join(",");
  if (camera.spread) parts.e = camera.spread;
  if (page.hidden.size) parts.h = runs([...page.hidden].sort((a, b) => a - b));
  if (page.selected >= 0) parts.b = page.selected;
  if (page.joint >= 0) parts.j = page.joint;
  return new URLSearchParams(parts).toString();
}

// Ascending numbers as ranges: 1-3,7.
function runs(numbers) {
  const out = [];
  for (const one of numbers) {
    if (out.length && out.at(-1)[1] === one - 1) out.at(-1)[1] = one;
    else out.push([one, one]);
  }
  return out.map(([a, b]) => (a === b ? a : `${a}-${b}`)).join(",");
}

function ofRuns(text, most) {
  const out = [];
  for (const part of text.split(",").filter(Boolean)) {
    const [a, b = a] = part.split("-").map(Number);
    for (let i = a; i <= Math.min(b, most - 1); i++) if (i >= 0) out.push(i);
  }
  return out;
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
  if (opacity > 0 && opacity <= 1) byId("opacity").value = page.opacity = opacity;
  camera.flat = parts.get("f") === "1";
  const [axis, at, side] = (parts.get("x") ?? "-1,0,1").split(",").map(Number);
  if ([-1, 0, 1, 2].includes(axis) && Math.abs(at) <= 1) setSection(axis, at, side < 0 ? -1 : 1);
  const spread = Number(parts.get("e"));
  camera.spread = spread >= 0 && spread <= 1.5 ? spread : 0;
  byId("spread").value = camera.spread;
  page.hidden = new Set(ofRuns(parts.get("h") ?? "", data.count));
  changeHidden();
  const [azimuth, elevation, distance, ...target] = numbers;
  camera.go({ azimuth, elevation, distance: Math.max(distance, 1e-9), target }, 0);
  camera.fits = parts.get("a") ?? "";
  refit();
  if (whole("b", data.count) >= 0) actions.select(whole("b", data.count));
  if (whole("j", data.contacts.a.length) >= 0) actions.selectJoint(whole("j", data.contacts.a.length));
  return true;
}
