// What lies under the pointer; distances; blocks found by their names.

const NEAR_JOINT = 11; // [CSS pixels] from the middle of a joint: it is meant

// What lies under the pointer: { block } or { joint } or nothing.
function under(event) {
  if (!renderer) return {};
  const box = canvas.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  interrupt();
  const view = currentView(canvas.width / Math.max(1, canvas.clientWidth));
  const joints = view.time === 0 && !page.acts;
  const polygons = joints ? view.layers.filter((layer) => layer.kind === "polygons") : [];
  // also where a view looks along them
  const faces = joints && stage().layers.some((layer) => shown(layer) && layer.corners && layer.interface);
  const joint = faces ? jointNear(x, y, view) : -1;
  if (joint >= 0) return { joint };
  const row = canvas.height - 1 - Math.floor(y * view.ratio);
  const found = pick(renderer, Math.floor(x * view.ratio), row, view, page.opacity < 1 ? polygons : []);
  if (found === 0) return {};
  return found <= data.count ? { block: found - 1 } : { joint: found - 1 - data.count };
}

// The joint whose middle is nearest to a place of the picture, -1 where none is near.
function jointNear(x, y, view) {
  if (page.opacity >= 1) return -1;
  const { a, b, centroid } = data.contacts;
  const size = sizeOf();
  let [best, joint] = [NEAR_JOINT ** 2, -1];
  for (let i = 0; i < a.length; i++) {
    if (page.hidden.has(a[i]) || page.hidden.has(b[i])) continue;
    const p = vec.add(centroid.subarray(3 * i, 3 * i + 3), awayOf(data, view, a[i], b[i]));
    const at = projected(view.projection, p, size.width, size.height);
    if (!at || isBeyond(view.section, p)) continue;
    const distance = (at.x - x) ** 2 + (at.y - y) ** 2;
    if (distance < best) [best, joint] = [distance, i];
  }
  return joint;
}

function clicked(event) {
  if (page.measuring) return measureAt(event);
  const { block, joint } = under(event);
  if (page.acts && block !== undefined) return page.acts.clicked(block, event);
  if (joint !== undefined) actions.selectJoint(joint);
  else actions.select(block ?? -1);
  return undefined;
}

// What a press grabs, or null: beside the blocks one turns the model.
function grabbed(event) {
  if (!page.acts || page.measuring || event.button !== 0 || event.shiftKey) return null;
  const { block } = under(event);
  return block === undefined ? null : page.acts.grabbed(block, event);
}

function hovered(event) {
  const tip = byId("tip");
  const found = event ? under(event) : {};
  const before = page.hovered;
  page.hovered = found.block ?? -1;
  if (before !== page.hovered && cost < VERY_SLOW) redraw(); // else the tip alone tells
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
  if (page.acts) return page.acts.says(block);
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

function setMeasuring(on) {
  page.measuring = on ? [] : null;
  byId("measure").setAttribute("aria-pressed", String(on));
  say(on ? "click two corners of blocks" : "");
  redraw();
}
