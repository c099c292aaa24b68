// Where the page looks from: fitted and straight views, and the view as text.

const flightTime = () => (still.matches ? 0 : FLIGHT);

// What the texts over the picture leave free, as shares of it: left, right, top, bottom.
function insets() {
  const { width, height } = sizeOf();
  const shareOf = (id) => byId(id).offsetHeight / height;
  const top = Math.min(0.3, shareOf("verdict") + 8 / height);
  const legend = byId("legend");
  const beside = width > height && legend.offsetWidth < 0.3 * width;
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

function fitAll() {
  camera.flat = false;
  fit();
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
