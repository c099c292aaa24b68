// Puts the parts together: keys, controls, and the first picture.

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

function connectSliders() {
  const onInput = (id, change) => byId(id).addEventListener("input", (event) => {
    change(Number(event.target.value));
    redraw(true);
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
    setSection(event.target.value === "" ? -1 : Number(event.target.value), page.section.at);
  });
  byId("spread").addEventListener("change", () => fit());
  byId("details").addEventListener("toggle", () => camera.fits && fit()); // the model has the room that is left
}

function connect() {
  followPointers(canvas, camera, { clicked, hovered, grabbed });
  canvas.addEventListener("dblclick", (event) => page.acts || centreOn(under(event).block));
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
  const resized = () => {
    if (canvas.clientWidth > 0 && !camera.flight) refit();
    redraw();
  };
  new ResizeObserver(() => { // also told of the size that a page opens with
    const { width, height } = viewNow();
    if (!pictures || canvas.width !== width || canvas.height !== height) resized();
  }).observe(canvas);
  window.addEventListener("resize", resized); // a new pixel ratio; before the frame is drawn, the observer is after it
  window.addEventListener("hashchange", () => readView(location.hash.slice(1)));
  for (const one of [darkness, forcing]) one.addEventListener("change", refreshPanels);
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
stageRows();
connect();
choosePreset(data.preset);
setStage(data.opens);
camera.flat = data.flat;
fit(undefined, undefined, 0);
if (data.section) setSection(...data.section);
readView(location.hash.slice(1));
if (stage().plays && !still.matches) setTimeout(() => page.time === inPlace() && play("motion"), 900);
connectAround();
