// Drawn over the picture: names, numbers, the scale bar, the directions of x, y, z and gravity.

const MOST_LABELS = 250;
const GIZMO = 34; // [CSS pixels], length of an axis
const CORNER = 3 * GIZMO; // what they take of the corner with their names

// Labels [{ x, y, depth, text }] that do not cover each other, near ones first.
function apart(labels, measure, height) {
  const kept = [];
  for (const label of labels.sort((a, b) => a.depth - b.depth)) {
    if (kept.length >= MOST_LABELS) break;
    const half = measure(label.text) / 2 + 3;
    const clear = kept.every((other) => Math.abs(other.x - label.x) > half + other.half
      || Math.abs(other.y - label.y) > height);
    if (clear) kept.push({ ...label, half });
  }
  return kept;
}

// Names and numbers: on what is seen of a block, or in its middle where blocks are glassy. While pictures
// of many blocks come slowly nothing is looked for; few keep them, as a page may open with such a picture.
function blockLabels(data, stage, view, size, { names, numbers, hidden }) {
  const out = layerLabels(stage, view, size);
  if (!names && !numbers) return out;
  const solid = view.showBlocks && view.opacity >= 1 && renderer;
  if (solid && view.hurried && data.count >= MANY) return out;
  const seen = solid ? seenBlocks(renderer, view, size) : null;
  const { centroid, number } = data.blocks;
  for (let i = 0; i < data.count; i++) {
    if (stage.state[i] === 0 || hidden.has(i)) continue;
    const told = [numbers && number[i] > 0 ? String(number[i]) : "", names ? data.blocks.names[i] : ""];
    const text = told.filter(Boolean).join(" ");
    if (!text) continue;
    const c = centroid.subarray(3 * i, 3 * i + 3);
    const middle = vec.add(c, awayOf(data, view, i));
    const place = projected(view.projection, middle, size.width, size.height);
    if (seen ? !seen.has(i) : isBeyond(view.section, middle)) continue;
    if (!place || place.x < 0 || place.y < 0 || place.x > size.width || place.y > size.height) continue;
    out.push({ ...place, ...seen?.get(i), text: text.length > 40 ? `${text.slice(0, 39)}\u2026` : text });
  }
  return out;
}

// What is written below entries of layers.
function layerLabels(stage, view, size) {
  return stage.layers.filter((layer) => layer.text && shownLayers.get(layer.key)).flatMap((layer) =>
    layer.text.flatMap(([i, text]) => {
      const place = projected(view.projection, layer.position.subarray(3 * i, 3 * i + 3), size.width, size.height);
      return place ? [{ ...place, y: place.y + 14, text }] : [];
    }));
}

function drawLabels(pen, labels, colours) {
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  const kept = apart(labels, (text) => pen.measureText(text).width, 15);
  for (const { x, y, text, half } of kept) {
    pen.fillStyle = colours.paper;
    pen.globalAlpha = 0.78;
    pen.fillRect(x - half, y - 7.5, 2 * half, 15);
    pen.globalAlpha = 1;
    pen.fillStyle = colours.ink;
    pen.fillText(text, x, y + 0.5);
  }
  return kept.length;
}

// A bar of a round length, and its text.
function scaleBar(metresPerPixel, most = 130) {
  const longest = most * metresPerPixel;
  const decade = 10 ** Math.floor(Math.log10(longest));
  const length = decade * [5, 2, 1].find((f) => f * decade <= longest);
  return { pixels: length / metresPerPixel, text: quantity(length, "m") };
}

// From below to the scale bar: beside the directions, or above them where there is no room for both beside the legend.
const scaleHeight = (width) => (width < 560 ? 112 : 16);

function drawScale(pen, view, size, colours) {
  const small = size.width < 560;
  const { pixels, text } = scaleBar(view.metresPerPixel, small ? 90 : 130);
  const [x, y] = [size.width - (small ? pixels + 16 : 250), size.height - scaleHeight(size.width)];
  pen.strokeStyle = pen.fillStyle = colours.ink;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y - 4);
  pen.lineTo(x, y);
  pen.lineTo(x + pixels, y);
  pen.lineTo(x + pixels, y - 4);
  pen.stroke();
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "bottom";
  pen.fillText(text, x + pixels / 2, y - 4);
}

// Arrows along x, y, z and gravity as they lie in the picture.
function drawGizmo(pen, view, gravity, size, colours) {
  const [x, y] = [size.width - GIZMO - 22, size.height - GIZMO - 24];
  const flat = (v) => [vec.dot(v, view.right) * GIZMO, -vec.dot(v, view.up) * GIZMO, vec.dot(v, view.back)];
  const arrows = [
    ["x", [1, 0, 0], colours.x], ["y", [0, 1, 0], colours.y], ["z", [0, 0, 1], colours.z],
    ["gravity", vec.scale(gravity, 1.1), colours.ink],
  ].map(([name, v, colour]) => ({ name, colour, at: flat(v) }));
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.font = "11px system-ui, sans-serif";
  const behind = arrows.sort((a, b) => a.at[2] - b.at[2]);
  const rims = behind.map((one) => ({ ...one, colour: colours.paper, rim: 4 })); // seen on blocks, too
  for (const { name, colour, at, rim = 0 } of [...rims, ...behind]) {
    const heavy = name === "gravity";
    pen.strokeStyle = pen.fillStyle = colour;
    const length = Math.hypot(at[0], at[1]);
    if (length < 4) continue;
    pen.lineWidth = rim + (heavy ? 2.5 : 1.8);
    const [ux, uy] = [at[0] / length, at[1] / length];
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + at[0] - 5 * ux, y + at[1] - 5 * uy);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(x + at[0], y + at[1]);
    pen.lineTo(x + at[0] - 7 * ux + 3.5 * uy, y + at[1] - 7 * uy - 3.5 * ux);
    pen.lineTo(x + at[0] - 7 * ux - 3.5 * uy, y + at[1] - 7 * uy + 3.5 * ux);
    pen.fill();
    const word = [name, x + at[0] + 9 * ux, y + at[1] + 9 * uy];
    if (!rim) pen.fillText(...word);
    else {
      pen.stroke();
      pen.lineWidth = rim;
      pen.strokeText(...word);
    }
  }
}

// Two corners of blocks and the distance between them.
function drawMeasure(pen, points, view, size, colours) {
  const at = points.map((p) => projected(view.projection, p, size.width, size.height));
  if (at.some((p) => p === null)) return;
  pen.strokeStyle = pen.fillStyle = colours.accent;
  pen.lineWidth = 2;
  for (const { x, y } of at) {
    pen.beginPath();
    pen.arc(x, y, 4, 0, 7);
    pen.fill();
  }
  if (at.length < 2) return;
  pen.beginPath();
  pen.moveTo(at[0].x, at[0].y);
  pen.lineTo(at[1].x, at[1].y);
  pen.stroke();
  const middle = { x: (at[0].x + at[1].x) / 2, y: (at[0].y + at[1].y) / 2, depth: -1 };
  const text = plain(vec.length(vec.sub(points[0], points[1])), "m");
  drawLabels(pen, [{ ...middle, text }], colours);
}

// Edges [[p, q]] around a joint as it is drawn: of its pieces those that lie along no other piece.
// Pieces of a curved joint are plane, so that their corners meet nearly, and not edge to edge.
function edgesAround(data, stage, joint) {
  const layer = stage.layers.find((one) => one.kind === "polygons" && one.interface?.includes(joint));
  if (!layer) return [];
  if (layer.around?.joint === joint) return layer.around.edges;
  const first = starts(layer.corners);
  const every = [];
  for (let piece = 0; piece < layer.corners.length; piece++) {
    if (layer.interface[piece] !== joint) continue;
    let before = layer.position.subarray(3 * first[piece + 1] - 3, 3 * first[piece + 1]);
    for (let i = first[piece]; i < first[piece + 1]; i++) {
      const at = layer.position.subarray(3 * i, 3 * i + 3);
      every.push({ piece, ends: [before, at] });
      before = at;
    }
  }
  const reach = 0.01 * data.blockSize;
  const edges = every.filter(({ piece, ends: [p, q] }) => {
    const middle = vec.scale(vec.add(p, q), 0.5);
    return !every.some((other) => other.piece !== piece && distanceTo(middle, ...other.ends) < reach);
  }).map((edge) => edge.ends);
  layer.around = { joint, edges };
  return edges;
}

// Of a point from a line between two others.
function distanceTo(point, from, to) {
  const [along, away] = [vec.sub(to, from), vec.sub(point, from)];
  const share = Math.min(1, Math.max(0, vec.dot(away, along) / (vec.dot(along, along) || 1)));
  return vec.length(vec.sub(away, vec.scale(along, share)));
}

// Kern, resultant and corner forces of the selected joint.
function drawJoint(pen, data, stage, joint, view, size, colours) {
  const { contacts } = data;
  const { a, b } = contacts;
  const away = awayOf(data, view, a[joint], b[joint]);
  const on = (p) => projected(view.projection, vec.add(p, away), size.width, size.height);
  const loop = (points, first, last) => {
    pen.beginPath();
    for (let i = first; i < last; i++) {
      const p = on(points.subarray(3 * i, 3 * i + 3));
      if (p) pen.lineTo(p.x, p.y);
    }
    pen.closePath();
    pen.stroke();
  };
  const [first, last] = [contacts.first[joint], contacts.first[joint + 1]];
  pen.lineWidth = 2;
  pen.strokeStyle = colours.ink;
  pen.beginPath();
  for (const edge of edgesAround(data, stage, joint)) {
    const [p, q] = edge.map(on);
    if (!p || !q) continue;
    pen.moveTo(p.x, p.y);
    pen.lineTo(q.x, q.y);
  }
  pen.stroke();
  if (contacts.kern) {
    pen.strokeStyle = colours.kern;
    pen.setLineDash([4, 3]);
    loop(contacts.kern, contacts.firstKern[joint], contacts.firstKern[joint + 1]);
    pen.setLineDash([]);
  }
  if (!stage.force) return;
  const frame = contacts.frame.subarray(9 * joint, 9 * joint + 9);
  const world = (i) => [0, 1, 2].map((k) => stage.force[3 * i] * frame[k]
    + stage.force[3 * i + 1] * frame[3 + k] + stage.force[3 * i + 2] * frame[6 + k]);
  let total = [0, 0, 0];
  let most = 0;
  for (let i = first; i < last; i++) {
    total = vec.add(total, world(i));
    most = Math.max(most, vec.length(world(i)));
  }
  const largest = vec.length(total);
  if (largest === 0) return;
  const scale = data.blockSize / largest;
  for (let i = first; i < last; i++) {
    drawArrow(pen, on, contacts.point.subarray(3 * i, 3 * i + 3), vec.scale(world(i), scale), colours.accent, 1.5);
  }
  const centre = stage.pressureCentre.subarray(3 * joint, 3 * joint + 3);
  drawArrow(pen, on, centre, vec.scale(total, scale), colours.network, 3);
}

function drawArrow(pen, on, from, vector, colour, width) {
  const [p, q] = [on(from), on(vec.add(from, vector))];
  if (!p || !q) return;
  const length = Math.hypot(q.x - p.x, q.y - p.y);
  if (length < 3) return;
  const [ux, uy] = [(q.x - p.x) / length, (q.y - p.y) / length];
  const head = Math.min(4 + 2 * width, length);
  pen.strokeStyle = pen.fillStyle = colour;
  pen.lineWidth = width;
  pen.beginPath();
  pen.moveTo(p.x, p.y);
  pen.lineTo(q.x - head * ux, q.y - head * uy);
  pen.stroke();
  pen.beginPath();
  pen.moveTo(q.x, q.y);
  pen.lineTo(q.x - head * ux + 0.45 * head * uy, q.y - head * uy - 0.45 * head * ux);
  pen.lineTo(q.x - head * ux - 0.45 * head * uy, q.y - head * uy + 0.45 * head * ux);
  pen.fill();
}
