// What stands beside the picture. Texts are always set as text, never as markup.

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

function swatch(colour, thin) {
  const made = element("span", undefined, { class: thin ? "swatch thin" : "swatch" });
  made.style.background = colour;
  return made;
}

function showVerdict(stage) {
  const headline = document.getElementById("headline");
  headline.textContent = stage.headline;
  headline.className = stage.verdict ?? "";
  document.getElementById("message").textContent = stage.message;
}

// The layer with its largest value: what the longest arrow stands for.
function layerText(layer) {
  if (layer.kind !== "arrows") return layer.label;
  return `${layer.label}, up to ${quantity(layer.largest, "N")}`;
}

function showLegend(data, stage, theme, shown) {
  const legend = document.getElementById("legend");
  legend.replaceChildren();
  const row = (colour, text, thin) => {
    const line = element("div");
    line.append(swatch(colour, thin), element("span", text));
    legend.append(line);
  };
  for (const [code, state] of Object.entries(data.states)) {
    if (stage.state.includes(Number(code))) row(state[theme], state.label, false);
  }
  for (const layer of stage.layers) {
    if (!shown(layer)) continue;
    row(data.colours[theme][layer.colour], layerText(layer), layer.kind !== "polygons");
  }
}

function showLayers(stage, theme, data, shown, toggle) {
  const box = document.getElementById("layers");
  box.replaceChildren();
  const entries = [
    { key: "blocks", label: "blocks" }, { key: "edges", label: "edges" }, ...stage.layers,
  ];
  for (const entry of entries) {
    const input = element("input", undefined, { type: "checkbox", "data-layer": entry.key });
    input.checked = shown(entry);
    input.addEventListener("change", () => toggle(entry.key, input.checked));
    const label = element("label");
    label.append(input);
    if (entry.colour) {
      label.append(swatch(data.colours[theme][entry.colour], entry.kind !== "polygons"));
    }
    label.append(element("span", entry.label));
    box.append(label);
  }
}

function showBlock(data, stage, block, select) {
  const box = document.getElementById("block");
  box.replaceChildren();
  if (block < 0) return;
  const { names, mass, volume } = data.blocks;
  box.append(element("h2", names[block]));
  const list = element("dl");
  const entry = (name, value) => list.append(element("dt", name), element("dd", value));
  entry("number", String(block));
  entry("state", data.states[stage.state[block]]?.label ?? "not placed");
  entry("mass", plain(mass[block], "kg"));
  entry("volume", plain(volume[block], "m\u00b3"));
  if (stage.prop) {
    const force = stage.prop.subarray(6 * block, 6 * block + 3);
    const moment = stage.prop.subarray(6 * block + 3, 6 * block + 6);
    if (vec.length(force) + vec.length(moment) > 0) {
      entry("prop force", quantity(vec.length(force), "N"));
      entry("prop moment", quantity(vec.length(moment), "N m"));
    }
  }
  box.append(list, contactTable(data, stage, block, select));
}

function contactTable(data, stage, block, select) {
  const found = data.interfacesOf[block];
  if (found.length === 0) return element("p", "touches no other block");
  const { a, b, area } = data.contacts;
  const forces = stage.normal !== null;
  const table = element("table");
  table.append(element("caption", `${found.length} interface${found.length === 1 ? "" : "s"}`));
  const head = table.createTHead().insertRow();
  const titles = forces
    ? [["with", ""], ["normal", "normal force, pressure positive"],
       ["shear", "force in the plane of the interface"],
       ["friction", "share of the friction that is used"]]
    : [["with", ""], ["area", "area of the interface"]];
  for (const [text, title] of titles) head.append(element("th", text, { scope: "col", title }));
  const body = table.createTBody();
  for (const i of found) {
    const other = a[i] === block ? b[i] : a[i];
    const row = body.insertRow();
    const go = element("button", data.blocks.names[other], { type: "button" });
    go.title = data.blocks.names[other];
    go.addEventListener("click", () => select(other));
    row.insertCell().append(go);
    const values = forces
      ? [quantity(stage.normal[i], "N"), quantity(stage.tangential[i], "N"),
         percent(stage.utilisation[i])]
      : [plain(area[i], "m\u00b2")];
    for (const value of values) row.insertCell().textContent = value;
  }
  return table;
}

function percent(share) {
  return Number.isFinite(share) ? `${Math.round(100 * share)} %` : "\u221e";
}
