// Puts answers into the picture: another stage of the same model, or another model.

let firstAnswer = true;
let greeting = !location.hash; // until the first verdict, where nothing was asked before it
let planKept = null; // the data of the load case while a plan is shown
const planShown = () => planKept !== null;

// Frees what the graphics card keeps for the layers of the stage before.
function forgetLayers() {
  if (!renderer) return;
  const { gl } = renderer;
  for (const { array, index, texture } of renderer.layerBuffers.values()) {
    if (array) gl.deleteVertexArray(array);
    if (index) gl.deleteBuffer(index);
    if (texture) gl.deleteTexture(texture);
  }
  renderer.layerBuffers.clear();
}

function knowLayers() {
  const preset = data.presets[page.preset];
  for (const layer of data.stages.flatMap((one) => one.layers)) {
    if (shownLayers.has(layer.key)) continue;
    shownLayers.set(layer.key, known.has(layer.key) ? preset.layers.includes(layer.key) : layer.visible);
  }
}

function renewPresets() {
  byId("presets").replaceChildren();
  presetButtons();
  for (const one of byId("presets").children) {
    one.setAttribute("aria-pressed", String(one.dataset.preset === page.preset));
  }
}

// Those of the model with the friction of the answer, or those with edges and corners that touch as well.
function showContacts(more, array) {
  data.own ??= data.contacts;
  const { friction } = live.asked;
  if (more) decodeArrays(more, array);
  const own = friction === null ? data.own : { ...data.own, friction: data.own.friction.map(() => friction) };
  if ((more ?? own) !== data.contacts) useContacts(data, more ?? own);
  if (page.joint >= data.contacts.a.length) page.joint = -1;
}

// One answer: the stage takes the place of the one before, the eye stays where it is; but what the first ones bring,
// as a legend, arrows and a motion, is to be seen.
function showAnswer(text, quick) {
  const { stage: fresh, contacts, blobs } = JSON.parse(text);
  const array = arraysOf(blobs);
  decodeStage(fresh, array);
  showContacts(contacts, array);
  stop();
  forgetLayers();
  data.stages = [fresh];
  if (firstAnswer) {
    firstAnswer = false;
    page.wanted = "forces";
    applyPreset(fresh.plays ? "solid" : "forces");
  }
  knowLayers();
  renewPresets();
  setStage(0);
  if (fresh.moved) setTime(1);
  greeting &&= now === past.states[0];
  if (greeting && camera.fits) fit(camera.azimuth, camera.elevation, 0);
  greeting &&= quick;
  if (fresh.plays && !quick && !still.matches) play("motion");
}

// Another model, or a plan of it, in place of the one that is shown.
function showData(fresh) {
  stop();
  for (const key of Object.keys(data)) if (!(key in fresh)) delete data[key];
  Object.assign(data, fresh);
  page.hidden.clear();
  [page.selected, page.joint, page.hovered, page.stage] = [-1, -1, -1, 0];
  camera.half = data.half;
  camera.radius = Math.max(vec.length(data.half), 1e-9);
  if (renderer) {
    forgetLayers();
    renderer.stage = null;
    renderer.build();
  }
  byId("stage-box").hidden = data.stages.length < 2;
  byId("stage").max = data.stages.length - 1;
  byId("all").hidden = true;
  knowLayers();
  renewPresets();
  setStage(0);
  redraw();
}

async function showModel(number) {
  const { facts, scene } = await ask(`/model/${number}`);
  models.set(number, facts);
  planKept = null;
  byId("plan-leave").hidden = true;
  showData(readData(scene));
}

function showPlan(scene) {
  planKept ??= { ...data };
  showData(readData(scene));
  byId("plan-leave").hidden = false;
  setMode("look"); // a plan is looked at
  choosePreset("stages");
  play("stages");
}

function leavePlan() {
  if (!planShown()) return;
  const kept = planKept;
  planKept = null;
  byId("plan-leave").hidden = true;
  showData(kept);
  choosePreset("forces");
  send();
}

// Edges of a mend as they would be, or none.
function showGhostOf(ends) {
  const { layers } = stage();
  const at = layers.findIndex((layer) => layer.key === "live-ghost");
  if (at >= 0) layers.splice(at, 1);
  if (ends?.length) {
    const position = new Float32Array(ends.flatMap((p) => [0, 1, 2].map((i) => p[i] - data.origin[i])));
    const vector = new Float32Array(ends.flatMap((p) => [0, 1, 2].map((i) => p[3 + i] - p[i])));
    layers.push({
      key: "live-ghost", label: "the mend", kind: "lines", colour: "missed", position, vector,
      visible: true, width: 2, top: 0, scale: 1, largest: 0, unit: "", shape: "disc",
    });
    shownLayers.set("live-ghost", true);
  }
  redraw();
}
