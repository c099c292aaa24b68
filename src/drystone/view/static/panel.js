// What stands beside the picture: layers, and the card of the block or joint that is selected.

function showLayers(stage, theme, data, shown, toggle) {
  const box = document.getElementById("layers");
  box.replaceChildren();
  const entries = [
    { key: "blocks", label: "blocks" }, { key: "edges", label: "edges" },
    { key: "names", label: "names of blocks" }, { key: "ground", label: "ground and shadow" },
  ];
  if (data.blocks.number.some((number) => number > 0)) {
    entries.push({ key: "numbers", label: "numbers of blocks" });
  }
  if (stage.motion) entries.push({ key: "ghost", label: "ghost of the motion" });
  for (const entry of [...entries, ...stage.layers]) {
    const input = element("input", undefined, { type: "checkbox", "data-layer": entry.key });
    input.checked = shown(entry);
    input.addEventListener("change", () => toggle(entry.key, input.checked));
    const label = element("label");
    label.append(input);
    if (entry.colour) label.append(layerSwatch(entry, data.colours[theme]));
    label.append(element("span", entry.label));
    box.append(label);
  }
}

function entryList() {
  const list = element("dl");
  const entry = (name, value) => list.append(element("dt", name), element("dd", value));
  return { list, entry };
}

// actions: select, selectJoint, hide, isolate
function showBlock(data, stage, block, actions) {
  const { names, mass, volume, number } = data.blocks;
  const card = element("div");
  card.append(element("h2", `Block ${names[block]}`));
  const { list, entry } = entryList();
  if (number[block] > 0) entry(data.stages.some((one) => one.arrives) ? "step" : "number", String(number[block]));
  entry("index, from 0", String(block));
  entry("state", data.states[stage.state[block]]?.label ?? "not placed");
  entry("mass", plain(mass[block], "kg"));
  entry("volume", plain(volume[block], "m\u00b3"));
  if (stage.prop) {
    const force = stage.prop.subarray(6 * block, 6 * block + 3);
    const moment = stage.prop.subarray(6 * block + 3, 6 * block + 6);
    if (vec.length(force) + vec.length(moment) > 0) {
      entry("help needed, force", quantity(vec.length(force), "N"));
      entry("direction", directionText(force));
      entry("help needed, moment", quantity(vec.length(moment), "N m"));
    }
  }
  const row = element("div", undefined, { class: "row" });
  row.append(
    button("Hide", () => actions.hide(block)), button("Isolate", () => actions.isolate(block)),
  );
  card.append(list, row, contactTable(data, stage, block, actions));
  return card;
}

function directionText(v) {
  const size = vec.length(v);
  return Array.from(v, (x) => (x / size).toFixed(2).replace("-0.00", "0.00")).join(", ");
}

function contactTable(data, stage, block, actions) {
  const found = data.interfacesOf[block];
  if (found.length === 0) return element("p", "touches no other block");
  const { a, b, area } = data.contacts;
  const forces = stage.normal !== null;
  const table = element("table");
  table.append(element("caption", `${found.length} joint${found.length === 1 ? "" : "s"}`));
  const head = table.createTHead().insertRow();
  const titles = forces
    ? [["with", ""], ["normal", "normal force, pressure positive"],
       ["shear", "force in the plane of the joint"],
       ["friction", "share of the friction that is used"]]
    : [["with", ""], ["area", "area of the joint"]];
  for (const [text, title] of titles) head.append(element("th", text, { scope: "col", title }));
  const body = table.createTBody();
  for (const i of found) {
    const other = a[i] === block ? b[i] : a[i];
    const row = body.insertRow();
    const name = data.blocks.names[other];
    row.insertCell().append(button(name, () => actions.selectJoint(i), { title: `joint with ${name}` }));
    const values = forces
      ? [quantity(stage.normal[i], "N"), quantity(stage.tangential[i], "N"),
         percent(stage.utilisation[i])]
      : [plain(area[i], "m\u00b2")];
    for (const value of values) row.insertCell().textContent = value;
  }
  return table;
}

function percent(share) {
  if (share > 1.005 && share < Infinity) return "over 100 %"; // its corners carry it
  return Number.isFinite(share) ? `${Math.round(100 * share)} %` : "\u221e";
}

function jointName(data, joint) {
  const { a, b } = data.contacts;
  return `${data.blocks.names[a[joint]]} \u2013 ${data.blocks.names[b[joint]]}`;
}

function showJoint(data, stage, joint, actions) {
  const { a, b, area, friction } = data.contacts;
  const { names } = data.blocks;
  const card = element("div");
  card.append(element("h2", `Joint ${joint}: ${jointName(data, joint)}`));
  const { list, entry } = entryList();
  entry("area", plain(area[joint], "m\u00b2"));
  entry("friction coefficient", plain(friction[joint], ""));
  if (stage.normal) {
    entry("normal force", quantity(stage.normal[joint], "N"));
    entry("shear force", quantity(stage.tangential[joint], "N"));
    entry("friction used", percent(stage.utilisation[joint]));
    if (area[joint] > 0) entry("mean pressure", quantity(stage.normal[joint] / area[joint], "Pa"));
  }
  const row = element("div", undefined, { class: "row" });
  for (const block of [a[joint], b[joint]]) row.append(button(names[block], () => actions.select(block)));
  card.append(list, row, jointPlan(data, stage, joint));
  return card;
}

const SVG = "http://www.w3.org/2000/svg";

function svg(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// Where u and v of a plan point: an axis of the model with its sign, or its parts.
function planAxes(data, joint) {
  const frame = data.contacts.frame.subarray(9 * joint + 3, 9 * joint + 9);
  const [right, up] = [frame.subarray(0, 3), frame.subarray(3, 6)].map((way) => {
    const axis = way.findIndex((part) => Math.abs(part) > 0.995);
    if (axis < 0) return `(${[...way].map((part) => Number(part.toFixed(2)) + 0).join(", ")})`;
    return `${way[axis] < 0 ? "-" : "+"}${"xyz"[axis]}`;
  });
  return `right: ${right}, up: ${up}`;
}

// A joint seen against its normal, u to the right and v up: outline, kern, corner forces, resultant.
function jointPlan(data, stage, joint) {
  const { contacts } = data;
  const figure = element("figure");
  const frame = contacts.frame.subarray(9 * joint, 9 * joint + 9);
  const centre = contacts.centroid.subarray(3 * joint, 3 * joint + 3);
  const flat = (p) => {
    const away = vec.sub(p, centre);
    return [vec.dot(away, frame.subarray(3, 6)), -vec.dot(away, frame.subarray(6, 9))];
  };
  const loop = (points, first, last) => {
    const out = [];
    for (let i = first; i < last; i++) out.push(flat(points.subarray(3 * i, 3 * i + 3)));
    return out;
  };
  const [first, last] = [contacts.first[joint], contacts.first[joint + 1]];
  const corners = loop(contacts.point, first, last);
  const reach = Math.max(...corners.flat().map(Math.abs), 1e-9);
  const text = (points) => points.map(([x, y]) => `${(x / reach) * 80},${(y / reach) * 80}`).join(" ");
  const label = `Plan of the joint ${jointName(data, joint)}`;
  const picture = svg("svg", { viewBox: "-100 -100 200 200", role: "img", "aria-label": label });
  picture.append(svg("polygon", { class: "outline", points: text(corners) }));
  if (contacts.kern) {
    const kern = loop(contacts.kern, contacts.firstKern[joint], contacts.firstKern[joint + 1]);
    picture.append(svg("polygon", { class: "kern", points: text(kern) }));
  }
  if (stage.force) {
    const normal = (i) => Math.max(0, stage.force[3 * i]);
    let most = 0;
    for (let i = first; i < last; i++) most = Math.max(most, normal(i));
    for (let i = first; i < last && most > 0; i++) {
      const [x, y] = corners[i - first];
      const r = 14 * Math.sqrt(normal(i) / most);
      picture.append(svg("circle", { class: "corner", cx: (x / reach) * 80, cy: (y / reach) * 80, r }));
    }
    const [x, y] = flat(stage.pressureCentre.subarray(3 * joint, 3 * joint + 3));
    if (stage.normal[joint] > 0) {
      picture.append(svg("circle", { class: "centre", cx: (x / reach) * 80, cy: (y / reach) * 80, r: 5 }));
    }
  }
  const wide = plain(2 * reach, "m");
  const words = stage.force
    ? "Dashed: kern. Discs: corner forces by area. Dot: centre of pressure." : "Dashed: kern.";
  const told = `${words} Axes: ${planAxes(data, joint)}. The outline fits into a square of ${wide}.`;
  figure.append(picture, element("figcaption", told));
  return figure;
}

// The blocks whose names contain the text, those that begin with it first.
function matches(names, text, most = 12) {
  const wanted = text.toLowerCase();
  const found = [];
  for (let i = 0; i < names.length; i++) {
    const at = names[i].toLowerCase().indexOf(wanted);
    if (at >= 0) found.push([names[i].length === wanted.length ? -1 : at, i]);
  }
  found.sort((x, y) => x[0] - y[0] || x[1] - y[1]);
  return { blocks: found.slice(0, most).map(([, i]) => i), total: found.length };
}

const FAINT = 0.05; // what joints that carry less than this share of the largest force use of their friction says nothing
const PLANS = 4; // of joints below a list

// Lists of what is worst, largest first: [title, [{ name, value, action, joint }, ...]].
function worstLists(data, stage, actions, most = 8) {
  const lists = [];
  const top = (count, value) => {
    const order = Uint32Array.from({ length: count }, (_, i) => i).filter((i) => value(i) > 0);
    return Array.from(order.sort((i, j) => value(j) - value(i)).subarray(0, most));
  };
  if (stage.normal) {
    const joint = (i, value) => ({ name: jointName(data, i), value, action: () => actions.selectJoint(i), joint: i });
    const least = FAINT * stage.normal.reduce((x, y) => Math.max(x, y), 0);
    const used = (i) => (stage.normal[i] > least ? stage.utilisation[i] : 0);
    lists.push(["Largest normal force", top(stage.normal.length, (i) => stage.normal[i])
      .map((i) => joint(i, quantity(stage.normal[i], "N")))]);
    lists.push(["Most friction used", top(stage.normal.length, used)
      .map((i) => joint(i, percent(used(i)))).filter(({ value }) => value !== percent(0))]); // not rounding
  }
  if (stage.prop) {
    const force = (i) => vec.length(stage.prop.subarray(6 * i, 6 * i + 3));
    lists.push(["Most help needed", top(data.count, force).map((i) => ({
      name: data.blocks.names[i], value: quantity(force(i), "N"), action: () => actions.select(i),
    }))]);
  }
  return lists.filter(([, rows]) => rows.length);
}

function showWorst(data, stage, actions) {
  const box = document.getElementById("worst");
  box.replaceChildren();
  const lists = worstLists(data, stage, actions);
  document.getElementById("worst-box").hidden = lists.length === 0;
  for (const [title, rows] of lists) {
    const part = element("details");
    part.append(element("summary", title));
    const list = element("ol");
    for (const { name, value, action } of rows) {
      const item = element("li");
      item.append(button(name, action, { title: name }), element("span", value));
      list.append(item);
    }
    part.append(list);
    part.addEventListener("toggle", () => part.append(plansOf(data, stage, rows)), { once: true });
    box.append(part);
  }
}

// Plans of the first joints of a list, with kern and centre of pressure.
function plansOf(data, stage, rows) {
  const plans = element("div", undefined, { class: "plans" });
  for (const { name, value, action, joint } of rows.slice(0, PLANS)) {
    if (joint === undefined) continue;
    const plan = jointPlan(data, stage, joint);
    plan.addEventListener("click", action);
    plan.lastChild.textContent = `${name}, ${value}; ${planAxes(data, joint)}`;
    plans.append(plan);
  }
  return plans;
}
