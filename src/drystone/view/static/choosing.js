// What is chosen: the picture with a name, a block or a joint, what is hidden.

function refreshPanels() {
  showLegend(data, stage(), theme(), told());
  showLayers(stage(), theme(), data, shown, (key, on) => {
    shownLayers.set(key, on);
    redraw();
  });
  refreshCard();
}

function refreshCard() {
  const card = byId("card");
  card.replaceChildren();
  if (page.joint >= 0) card.append(showJoint(data, stage(), page.joint, actions));
  else if (page.selected >= 0) card.append(showBlock(data, stage(), page.selected, actions));
  tellAround();
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

// A row beside the picture that begins with the label of a stage shows it, as a mend of a list.
function stageRows() {
  for (const row of document.querySelectorAll(".chart p")) {
    const number = data.stages.findIndex(({ label }) => row.textContent.startsWith(`${label}: `));
    if (number < 0) continue;
    const shows = button("", () => stepStage(number - page.stage), { "data-stage": number });
    shows.append(...row.childNodes);
    row.replaceWith(shows);
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
