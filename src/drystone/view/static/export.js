// Files made on the page itself: a picture of pixels or of lines, and a table of joints.

function download(name, content, kind) {
  const link = element("a", undefined, { download: name });
  const address = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type: kind }));
  link.href = address;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// The name of a file made from this page: that of its model and its own title in plain letters.
function fileName(data, ending) {
  const file = new Map(data.facts).get("File") ?? "";
  const words = `${file.replace(/\.[^.]*$/, "")} ${file ? data.title.replace("drystone", "") : data.title}`;
  const stem = words.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "").slice(0, 60);
  return `${stem || "drystone"}.${ending}`;
}

// One row a joint, in SI units, with the digits that the page has.
function jointsCsv(data, stage) {
  const { a, b, area, friction } = data.contacts;
  const quoted = (text) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const number = (x) => (Number.isFinite(x) ? Number(x.toPrecision(7)) : x);
  const head = ["joint", "block_a", "block_b", "area_m2", "friction"];
  if (stage.normal) head.push("normal_N", "tangential_N", "friction_use");
  const rows = [head.join(",")];
  for (let i = 0; i < a.length; i++) {
    const row = [i, quoted(data.blocks.names[a[i]]), quoted(data.blocks.names[b[i]]), number(area[i]), number(friction[i])];
    if (stage.normal) row.push(...[stage.normal[i], stage.tangential[i], stage.utilisation[i]].map(number));
    rows.push(row.join(","));
  }
  return `${rows.join("\r\n")}\r\n`;
}

// The picture as lines and areas. Blocks and joints are laid over each other by the distance of
// their middles, so that where blocks reach past each other a side can be in the wrong order.
function pictureSvg(data, stage, view, size, theme, options) {
  const { width, height } = size;
  const parts = [];
  const { blocks, contacts } = data;
  const place = (p) => projected(view.projection, p, width, height);
  const apartOf = (a, b = a) => (a < 0 ? [0, 0, 0] : awayOf(data, view, a, b));
  const text = (points) => points.map((p) => `${p.x.toFixed(1)},${p.y.toFixed(1)}`).join(" ");
  const things = [];
  if (view.showBlocks) {
    const drawn = (i) => stage.state[i] !== 0 && !options.hidden.has(i);
    things.push(...blockPolygons(data, stage, view, theme, drawn, apartOf, place, text));
  }
  for (const layer of view.layers) {
    if (layer.kind === "polygons") things.push(...jointPolygons(layer, data, view, theme, apartOf, place, text, options));
  }
  things.sort((x, y) => y.depth - x.depth);
  parts.push(...things.map((thing) => thing.text));
  for (const layer of view.layers) parts.push(...layerMarks(layer, data, view, theme, apartOf, place, options));
  const paper = data.colours[theme].background;
  const title = escapeXml(stage.headline || data.title);
  return `<svg xmlns="${SVG}" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">`
    + `<title>${title}</title><rect width="100%" height="100%" fill="${paper}"/>`
    + `${parts.join("")}${options.captions}</svg>\n`;
}

function escapeXml(text) {
  return text.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`).replace(/[\x00-\x08\x0b\x0c\x0e-\x1f]/g, "");
}

// The sides of blocks that face the eye.
function blockPolygons(data, stage, view, theme, drawn, apartOf, place, text) {
  const { blocks } = data;
  const [firstPoint, firstFace, firstCorner] = [blocks.points, blocks.faces, blocks.corners].map(starts);
  const line = cssColour(view.edgeColour);
  const out = [];
  for (let block = 0; block < data.count; block++) {
    if (!drawn(block)) continue;
    const away = apartOf(block);
    const base = colourOf(data.states[stage.state[block]][theme]);
    const sides = [];
    for (let face = firstFace[block]; face < firstFace[block + 1]; face++) {
      const corners = [];
      for (let c = firstCorner[face]; c < firstCorner[face + 1]; c++) {
        const p = 3 * (firstPoint[block] + blocks.loop[c]);
        corners.push(vec.add(blocks.point.subarray(p, p + 3), away));
      }
      const flat = clipped(corners, view.section).map(place);
      if (flat.length < 3 || flat.some((p) => p === null)) continue;
      if (signedArea(flat) >= 0) { // the inside of a cut block is drawn as its cut
        if (view.sectioned) sides.unshift(`<polygon points="${text(flat)}" fill="${cssColour(view.cut)}"/>`);
        continue;
      }
      let n = [0, 0, 0];
      for (let i = 1; i + 1 < corners.length; i++) {
        n = vec.add(n, vec.cross(vec.sub(corners[i], corners[0]), vec.sub(corners[i + 1], corners[0])));
      }
      const light = 0.58 + 0.36 * Math.max(0, vec.dot(n, view.light) / (vec.length(n) || 1));
      const fill = cssColour(base.map((x) => Math.min(1, x * light)));
      sides.push(`<polygon points="${text(flat)}" fill="${fill}" fill-opacity="${view.opacity}" `
        + `stroke="${line}" stroke-width="0.6" stroke-linejoin="round"/>`);
    }
    const middle = place(vec.add(blocks.centroid.subarray(3 * block, 3 * block + 3), away));
    if (middle && sides.length) out.push({ depth: middle.depth, text: sides.join("") });
  }
  return out;
}

function signedArea(points) {
  let sum = 0;
  points.forEach((p, i) => {
    const q = points[(i + 1) % points.length];
    sum += p.x * q.y - q.x * p.y;
  });
  return sum;
}

// Each joint in the colour of its mean value.
function jointPolygons(layer, data, view, theme, apartOf, place, text, options) {
  const first = starts(layer.corners);
  const plainColour = data.colours[theme][layer.colour];
  const { a, b } = ownersOf(layer, data.contacts, layer.corners.length);
  const out = [];
  for (let face = 0; face < layer.corners.length; face++) {
    if (options.hidden.has(a[face]) || options.hidden.has(b[face])) continue;
    const there = [];
    let sum = 0;
    for (let c = first[face]; c < first[face + 1]; c++) {
      there.push(vec.add(layer.position.subarray(3 * c, 3 * c + 3), apartOf(a[face], b[face])));
      sum += layer.value ? layer.value[c] : 0;
    }
    const share = layer.top > 0 ? sum / there.length / layer.top : 0;
    const corners = clipped(there, view.section).map(place);
    if (corners.length < 3 || corners.some((p) => p === null)) continue;
    const fill = layer.value ? cssColour(rampColour(data.ramp[theme], share)) : plainColour;
    const depth = corners.reduce((total, p) => total + p.depth, 0) / corners.length;
    out.push({ depth, text: `<polygon points="${text(corners)}" fill="${fill}"/>` });
  }
  return out;
}

// Lines, arrows and markers over everything else.
function layerMarks(layer, data, view, theme, apartOf, place, options) {
  const colour = data.colours[theme][layer.colour];
  const out = [];
  if (layer.kind === "polygons") return out;
  const count = layer.position.length / 3;
  const { a, b } = ownersOf(layer, data.contacts, count);
  const line = (p, q, width, opacity, head) => {
    if (!p || !q) return;
    out.push(`<line x1="${p.x.toFixed(1)}" y1="${p.y.toFixed(1)}" x2="${q.x.toFixed(1)}" y2="${q.y.toFixed(1)}" `
      + `stroke="${colour}" stroke-width="${width.toFixed(2)}" stroke-opacity="${opacity.toFixed(2)}" stroke-linecap="round"/>`);
    const length = Math.hypot(q.x - p.x, q.y - p.y);
    if (!head || length < 3) return;
    const [ux, uy] = [(q.x - p.x) / length, (q.y - p.y) / length];
    const h = Math.min(5 + width, 0.6 * length);
    const side = (s) => `${(q.x - h * ux + s * 0.45 * h * uy).toFixed(1)},${(q.y - h * uy - s * 0.45 * h * ux).toFixed(1)}`;
    out.push(`<polygon points="${q.x.toFixed(1)},${q.y.toFixed(1)} ${side(1)} ${side(-1)}" fill="${colour}"/>`);
  };
  for (let i = 0; i < count; i++) {
    if (options.hidden.has(a[i]) || options.hidden.has(b[i])) continue;
    const from = vec.add(layer.position.subarray(3 * i, 3 * i + 3), apartOf(a[i], b[i]));
    if (isBeyond(view.section, from)) continue;
    const p = place(from);
    if (layer.kind === "markers") {
      const look = `fill="${colour}" stroke="${cssColour(view.outline)}"`;
      if (!p) continue;
      const [x, y] = [p.x.toFixed(1), p.y.toFixed(1)];
      if (layer.shape === "diamond") {
        out.push(`<path d="M${x} ${y}m-6 0l6 -6l6 6l-6 6z" ${look}/>`);
      } else out.push(`<circle cx="${x}" cy="${y}" r="5" ${look}/>`);
      continue;
    }
    const vector = layer.vector.subarray(3 * i, 3 * i + 3);
    if (layer.kind === "lines") {
      const share = layer.value && layer.top > 0 ? layer.value[i] / layer.top : 0.2;
      line(p, place(vec.add(from, vector)), Math.max(0.7, 7 * share * view.fine), Math.min(1, 0.2 + 10 * share), false);
      continue;
    }
    const v = vec.scale(vector, layer.scale * view.stretch);
    const halves = layer.single
      ? [[vec.sub(from, v), from]]
      : [0.5, -0.5].map((s) => [from, vec.add(from, vec.scale(v, s))]);
    for (const [x, y] of halves) {
      const [start, end] = layer.inward ? [y, x] : [x, y];
      line(place(start), place(end), 1.4 * layer.width, 1, true);
    }
  }
  return out;
}
