// The strip: sliders, buttons, and what becomes of every event of the server.

const SLIDERS = {
  tilt: { read: () => now.tilt, write: (tilt) => ({ tilt }) },
  direction: { read: () => now.direction, write: (direction) => ({ direction }) },
  friction: { read: () => now.friction ?? factsNow().friction?.[0] ?? 0, write: (friction) => ({ friction }) },
  gravity: { read: () => now.gravity ?? factsNow().gravity, write: (gravity) => ({ gravity }) },
};

function showControls() {
  for (const [id, { read }] of Object.entries(SLIDERS)) {
    const value = Number(read().toPrecision(6));
    if (document.activeElement !== byId(id)) byId(id).value = value;
    if (document.activeElement !== byId(`${id}-number`)) byId(`${id}-number`).value = value;
  }
  const [low, high] = factsNow().friction ?? [0, 0];
  const mixed = now.friction === null && high > low;
  byId("friction").title = mixed ? `${low} to ${high} in the model` : "";
  byId("undo").disabled = past.at === 0;
  byId("redo").disabled = past.at === past.states.length - 1;
  showChanges();
  showBlockActions();
}

function connectSlider(id, { write }) {
  for (const input of [byId(id), byId(`${id}-number`)]) {
    const value = () => (input.value === "" ? null : Number(input.value));
    input.addEventListener("input", () => value() !== null && change(write(value()), false));
    // an emptied field is as in the file
    input.addEventListener("change", () => change(write(value() ?? plainState(now.model)[id])));
    input.addEventListener("blur", showControls);
  }
}

// Towards where one looks, level: degrees from x towards y.
function lookingTowards() {
  const { back } = camera.axes();
  const [x, y] = turnedBetween(vec.scale(back, -1), camera.upward, [0, 0, 1]);
  return Math.hypot(x, y) < 1e-6 ? now.direction : Math.round((Math.atan2(y, x) * 180) / Math.PI);
}

function showEdge({ direction, stands, falls, message, stopped }) {
  const box = byId("edge-answer");
  const degrees = (x) => `${Number(x.toPrecision(4))}\u00b0`;
  let text = `Towards ${direction}\u00b0 it stands up to ${stands === null ? "?" : degrees(stands)}`;
  if (stands === null) text = `Towards ${direction}\u00b0: it does not stand upright`;
  else if (falls === null) text += `; no tilt was found at which it falls`;
  else text += ` and falls at ${degrees(falls)}`;
  if (stopped) text += ` (${stopped})`;
  box.replaceChildren(element("p", message ? `${text}: ${message}` : text));
  if (stands !== null) box.append(button("Last that stands", () => change({ tilt: stands, direction })));
  if (falls !== null) box.append(button("First that falls", () => change({ tilt: falls, direction })));
  if (stands !== null) change({ tilt: stands, direction });
}

function busy(on, text = "") {
  byId("task-stop").hidden = !on;
  byId("live-state").textContent = on ? text || "working" : text;
}

async function newFile({ model, broken: why }) {
  broken = why ? `The file cannot be read, so the model before is kept. ${inWords(why)}` : "";
  complain("");
  if (!model || model === begins.model) return;
  begins.model = model;
  leavePlan();
  await showModel(model);
  const here = new Set(data.blocks.names);
  const kept = {
    model, removed: now.removed.filter((one) => here.has(one)),
    pushes: now.pushes.filter((one) => here.has(one.block)),
    moves: now.moves.filter((one) => here.has(one.block)),
    supports: now.supports?.filter((one) => here.has(one)) ?? null,
  };
  const fixed = kept.supports ?? factsNow().supports;
  kept.pushes = kept.pushes.filter((one) => !fixed.includes(one.block));
  kept.moves = kept.moves.filter((one) => fixed.includes(one.block));
  cases = cases.map((one) => ({ ...one, state: { ...one.state, model } }));
  change(kept);
  checkCases();
}

let atOnce = ""; // how long the quick answer took

const HEAR = {
  file: newFile,
  quick: ({ wish, answer, picture }) => {
    answered(wish);
    if (wish === live.wish) stood = live.asked;
    if (planShown()) return;
    showAnswer(picture, true);
    atOnce = `${now.moves.length ? "first answer" : "uniform stiffness"}: ${Math.round(answer.computed_ms)} ms`;
    byId("live-state").textContent = atOnce;
  },
  following: ({ wish, picture }) => {
    if (wish === live.wish && !planShown()) showAnswer(picture, true);
  },
  whole: ({ wish, answer, picture }) => {
    if (wish !== live.wish) return;
    wholeAnswer = { state: live.asked, headline: answer.headline, verdict: answer.verdict.toUpperCase() };
    if (planShown()) return;
    showAnswer(picture, false);
    const early = answer.stopped ? `; ${answer.stopped}` : "";
    byId("live-state").textContent = `${atOnce}; verdict: ${(answer.computed_ms / 1000).toPrecision(2)} s${early}`;
  },
  progress: ({ stage: at, done, total }) => {
    byId("live-state").textContent = total ? `${at} (${done} of ${total})` : at;
  },
  error: ({ wish, what, where, remedy }) => {
    answered(wish);
    busy(false);
    if (wish === live.wish) refuse(inWords({ what, where, remedy }));
    else complain(inWords({ what, where, remedy }));
  },
  limit: (event) => {
    busy(false);
    showEdge(event);
  },
  mend: ({ mend, number }) => showMend(mend, number),
  mends: (event) => {
    busy(false);
    showMends(event);
  },
  model: mended,
  unchanged: ({ message }) => {
    busy(false);
    byId("mends").replaceChildren(element("p", message));
  },
  plan: (event) => {
    busy(false);
    showPlanAnswer(event);
  },
  case: hearCase,
  saved: ({ text }) => {
    busy(false);
    download(savedName("model.json"), text, "application/json");
  },
};

const savedName = (ending) => `${begins.name.replace(/\.[^.]*$/, "")}-${ending}`;

// Where the model is mended, the lines read the file that the button Model saves.
async function pythonLines() {
  const extra = now.model === begins.model ? {} : { saved: savedName("model.json") };
  return ask("/live/python", { window: live.window, model: now.model, wish: wishOf(now), extra });
}

function connectStrip() {
  byId("fold").before(byId("live-trouble")); // seen where the controls are folded or scrolled
  for (const [id, slider] of Object.entries(SLIDERS)) connectSlider(id, slider);
  const onClick = (id, action) => byId(id).addEventListener("click", () => {
    Promise.resolve(action()).catch((error) => complain(error.message));
  });
  onClick("undo", () => step(-1));
  onClick("redo", () => step(1));
  onClick("reset", async () => {
    if (now.model !== begins.model) await showModel(begins.model);
    change(plainState(begins.model));
  });
  onClick("edge", () => {
    leavePlan();
    task("limit", {}, { ...now, direction: lookingTowards() });
  });
  onClick("mends-find", () => {
    byId("mends").replaceChildren();
    return task("mends");
  });
  onClick("plan-find", () => task("plan"));
  onClick("recut-find", () => {
    leavePlan();
    return task("recut");
  });
  onClick("plan-leave", leavePlan);
  onClick("task-stop", () => {
    busy(false);
    return ask("/live/end", { window: live.window });
  });
  onClick("cases-check", checkCases);
  onClick("save-model", () => task("save"));
  onClick("save-picture", exportPng);
  onClick("save-case", async () => {
    const { case: one } = await pythonLines();
    download(savedName("case.json"), `${JSON.stringify(one, null, 1)}\n`, "application/json");
  });
  onClick("save-python", async () => {
    byId("python").hidden = false;
    byId("python").value = (await pythonLines()).python;
    byId("python").select();
  });
  byId("case-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const name = byId("case-name").value.trim() || `case ${cases.length + 1}`;
    keepCase(name);
    byId("case-name").value = "";
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || /^(INPUT|TEXTAREA)$/.test(event.target.tagName)) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    step(key === "y" || event.shiftKey ? 1 : -1);
  });
}

byId("fold").addEventListener("click", () => fit(camera.azimuth, camera.elevation, 0));
connectPush();
connectStrip();
showControls();
let greeted = false;
listen((event) => {
  if (!greeted) {
    greeted = true;
    send();
  }
  HEAR[event.event]?.(event);
}, complain);
