// What colours, widths and marks stand for; the head of the picture. Texts are always set as text.

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

function button(text, action, attributes = {}) {
  const made = element("button", text, { type: "button", ...attributes });
  made.addEventListener("click", action);
  return made;
}

function swatch(colour, shape) {
  const made = element("span", undefined, { class: `swatch ${shape}`, "aria-hidden": "true" });
  made.style.background = made.style.color = colour;
  return made;
}

const FALLING = 3; // the state of a block that falls
const ADDED = 8; // and of one that was added
const SHAPE_OF = { polygons: "", arrows: "arrow", lines: "thick", markers: "disc" };

function layerSwatch(layer, colours) {
  const shape = layer.kind === "markers" ? layer.shape : SHAPE_OF[layer.kind];
  return swatch(colours[layer.colour], shape);
}

const amount = ({ unit }, value) => (unit === "" ? percent(value) : quantity(value, unit));

// The layer with its largest value: what the longest arrow or the widest line stands for.
function layerText(layer) {
  const upTo = (text) => `${layer.label}, up to ${text.replaceAll(" ", "\u00a0")}`; // one word with its unit
  if (layer.kind === "arrows") return upTo(quantity(layer.largest, layer.unit));
  if (layer.kind === "lines" && layer.value) return upTo(amount(layer, layer.largest));
  if (layer.kind === "markers") return `${layer.label} (${layer.position.length / 3})`;
  return layer.label;
}

// The colour of a block in a state as it is seen on the ground of the page: glassy blocks are paler.
function blockColour(state, colour, ground, opacity) {
  const share = state === ADDED ? Math.max(opacity, ADDED_OPACITY) : opacity;
  const under = colourOf(ground);
  return cssColour(colourOf(colour).map((part, i) => under[i] + share * (part - under[i])));
}

// Rows of the legend as plain values, for the page and for what is exported.
function legendRows(data, stage, theme, told) {
  const rows = [];
  for (const [code, state] of Object.entries(data.states)) {
    if (told.blocks && stage.state.includes(Number(code))) {
      const colour = blockColour(Number(code), state[theme], data.colours[theme].background, told.opacity);
      rows.push({ colour, text: state.label, shape: Number(code) === 6 ? "hatch" : "" });
    }
  }
  for (const layer of told.layers) {
    const colour = data.colours[theme][layer.colour];
    if (layer.kind === "polygons" && layer.value) rows.push({ bar: layer, text: layer.label });
    else {
      const shape = layer.kind === "markers" ? layer.shape : SHAPE_OF[layer.kind];
      rows.push({ colour, text: layerText(layer), shape });
    }
  }
  if (told.ghost && stage.motion.some((way) => way !== 0)) {
    const name = stage.motionName.toLowerCase();
    const text = stage.arrives ? "where the block comes from" : `${name}, at its end`;
    const [light, dark] = stage.state.includes(FALLING) ? ["#852161", "#f2add9"] : ["#404040", "#cccccc"];
    rows.push({ colour: theme === "dark" ? dark : light, text, shape: "dashed" });
  }
  return rows;
}

// What decides on the rows while a stage is shown.
const keysOf = ({ blocks, opacity, ghost, layers }) => [blocks, opacity, ghost, ...layers.map(({ key, kind }) => key + kind)].join();

function showLegend(data, stage, theme, told) {
  const legend = document.getElementById("legend");
  legend.dataset.told = keysOf(told);
  legend.replaceChildren();
  for (const row of legendRows(data, stage, theme, told)) {
    if (row.bar) {
      legend.append(colourBar(row.bar, data.ramp[theme]));
      continue;
    }
    const line = element("div");
    line.append(swatch(row.colour, row.shape), element("span", row.text));
    legend.append(line);
  }
}

// Ends and middle of a colour bar, in words.
function barTexts(layer) {
  const texts = [0, 0.5, 1].map((share) => amount(layer, share * layer.top));
  if (layer.largest > 1.001 * layer.top) texts[2] = `\u2265 ${texts[2]}`;
  return texts;
}

function colourBar(layer, stops) {
  const box = element("div", undefined, { class: "bar" });
  const strip = element("span", undefined, { class: "strip", "aria-hidden": "true" });
  strip.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  const ticks = element("span", undefined, { class: "ticks" });
  for (const text of barTexts(layer)) ticks.append(element("span", text));
  box.append(element("span", layer.label), strip, ticks);
  return box;
}

function showHeader(data, stage) {
  const headline = document.getElementById("headline");
  headline.textContent = stage.headline || data.title;
  headline.className = stage.role ?? "";
  const facts = [...new Map([...data.facts, ...stage.facts])];
  // No line begins with a dot, and no date and no version is broken.
  document.getElementById("asked").textContent = stage.asked.replaceAll(" \u00b7", "\u00a0\u00b7")
    .replace(/(\d{4})-(\d\d)-(\d\d)/, "$1\u2011$2\u2011$3").replace(/drystone (?=\d)/, "drystone\u00a0");
  document.getElementById("message").textContent = stage.message;
  const list = document.getElementById("facts");
  list.replaceChildren();
  for (const [name, text] of [...facts, ["Made", data.made]]) {
    list.append(element("dt", name), element("dd", text));
  }
}
