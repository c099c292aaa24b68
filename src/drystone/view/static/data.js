// The page's data: base64 into typed arrays, local numbers into global ones, flat meshes.

const ARRAY_TYPES = { f4: Float32Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };

function readData(text = document.getElementById("drystone-data").textContent) {
  const data = JSON.parse(text);
  if (data.format !== "drystone-page" || data.version !== 2) {
    throw new Error("this page does not understand its own data");
  }
  const array = arraysOf(data.blobs);
  for (const part of [data.blocks, data.contacts]) decodeArrays(part, array);
  for (const stage of data.stages) decodeStage(stage, array);
  data.blobs = null;
  data.count = data.blocks.names.length;
  useContacts(data, data.contacts);
  return data;
}

function useContacts(data, contacts) {
  data.contacts = contacts;
  data.interfacesOf = interfacesOf(data);
  contacts.first = starts(contacts.corners);
  contacts.firstKern = contacts.kerns ? starts(contacts.kerns) : null;
}

// Gives the array of a description, from base64 texts.
function arraysOf(blobs) {
  const bytes = blobs.map(decodeBase64);
  return (spec) => spec && new ARRAY_TYPES[spec.type](bytes[spec.blob].buffer);
}

function decodeStage(stage, array) {
  decodeArrays(stage, array);
  stage.layers.forEach((layer) => decodeArrays(layer, array));
}

function decodeBase64(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

function decodeArrays(holder, array) {
  for (const [name, value] of Object.entries(holder)) {
    if (value && typeof value === "object" && "blob" in value) holder[name] = array(value);
  }
}

function starts(counts) {
  const out = new Uint32Array(counts.length + 1);
  for (let i = 0; i < counts.length; i++) out[i + 1] = out[i] + counts[i];
  return out;
}

// For each block the numbers of its interfaces.
function interfacesOf(data) {
  const found = Array.from({ length: data.count }, () => []);
  const { a, b } = data.contacts;
  for (let i = 0; i < a.length; i++) {
    found[a[i]].push(i);
    found[b[i]].push(i);
  }
  return found;
}

// Faces with corners of their own (flat shading), and the range of indices of each block.
function blockMesh(blocks) {
  const { point, loop, triangle } = blocks;
  const firstPoint = starts(blocks.points);
  const firstFace = starts(blocks.faces);
  const firstCorner = starts(blocks.corners);
  const corners = loop.length;
  const position = new Float32Array(3 * corners);
  const normal = new Int8Array(4 * corners);
  const owner = new Uint32Array(corners);
  const index = new Uint32Array(triangle.length);
  const indexStart = new Uint32Array(blocks.points.length + 1);
  let used = 0;
  for (let block = 0; block < blocks.points.length; block++) {
    for (let face = firstFace[block]; face < firstFace[block + 1]; face++) {
      const first = firstCorner[face];
      const last = firstCorner[face + 1];
      for (let c = first; c < last; c++) {
        const p = 3 * (firstPoint[block] + loop[c]);
        position.set(point.subarray(p, p + 3), 3 * c);
        owner[c] = block;
      }
      const n = loopNormal(position, first, last);
      for (let c = first; c < last; c++) {
        for (let i = 0; i < 3; i++) normal[4 * c + i] = Math.round(127 * n[i]);
      }
      const end = used + 3 * (last - first - 2);
      for (; used < end; used++) index[used] = first + triangle[used];
    }
    indexStart[block + 1] = used;
  }
  return { position, normal, owner, index, indexStart };
}

function loopNormal(position, first, last) {
  const sum = areaVector(position, first, last);
  const length = vec.length(sum);
  return length > 0 ? vec.scale(sum, 1 / length) : [0, 0, 0];
}

// Normal of a loop, twice as long as its area.
function areaVector(position, first, last) {
  const at = (c) => [0, 1, 2].map((i) => position[3 * c + i] - position[3 * first + i]);
  let sum = [0, 0, 0];
  for (let c = first + 1; c + 1 < last; c++) sum = vec.add(sum, vec.cross(at(c), at(c + 1)));
  return sum;
}

// Two texels an edge: one end and the block, the other end.
function edgeSegments(blocks) {
  const { point, edge } = blocks;
  const firstPoint = starts(blocks.points);
  const segments = new Float32Array(4 * edge.length);
  let e = 0;
  for (let block = 0; block < blocks.points.length; block++) {
    for (let k = 0; k < blocks.edges[block]; k++, e++) {
      for (let side = 0; side < 2; side++) {
        const p = 3 * (firstPoint[block] + edge[2 * e + side]);
        segments.set(point.subarray(p, p + 3), 8 * e + 4 * side);
        segments[8 * e + 4 * side + 3] = block;
      }
    }
  }
  return segments;
}

// The two blocks that each entry of a layer belongs to; -1 where it belongs to none.
function ownersOf(layer, contacts, count) {
  const a = new Float32Array(count).fill(-1);
  const b = new Float32Array(count).fill(-1);
  for (let i = 0; i < count; i++) {
    if (layer.interface) {
      a[i] = contacts.a[layer.interface[i]];
      b[i] = contacts.b[layer.interface[i]];
    } else if (layer.block) a[i] = b[i] = layer.block[i];
  }
  return { a, b };
}

// Three texels an arrow, line or marker: where it is and block a; how it points and block b; its
// value as a share of the largest.
function vectorSegments(layer, contacts) {
  const count = layer.position.length / 3;
  const { a, b } = ownersOf(layer, contacts, count);
  const segments = new Float32Array(12 * count);
  for (let i = 0; i < count; i++) {
    segments.set(layer.position.subarray(3 * i, 3 * i + 3), 12 * i);
    if (layer.vector) segments.set(layer.vector.subarray(3 * i, 3 * i + 3), 12 * i + 4);
    segments[12 * i + 3] = a[i];
    segments[12 * i + 7] = b[i];
    segments[12 * i + 8] = layer.value && layer.top > 0 ? layer.value[i] / layer.top : 1;
  }
  return segments;
}

// What the corners of polygons carry beside their place: value, blocks a and b, number to pick.
function polygonCorners(layer, contacts, firstNumber) {
  const corners = layer.position.length / 3;
  const { a, b } = ownersOf(layer, contacts, layer.corners.length);
  const value = new Float32Array(corners);
  const owner = new Float32Array(2 * corners);
  const number = new Uint32Array(corners);
  let c = 0;
  for (let face = 0; face < layer.corners.length; face++) {
    for (let k = 0; k < layer.corners[face]; k++, c++) {
      value[c] = layer.value && layer.top > 0 ? layer.value[c] / layer.top : 0;
      owner.set([a[face], b[face]], 2 * c);
      number[c] = layer.interface ? firstNumber + layer.interface[face] : 0;
    }
  }
  return { value, owner, number };
}

function polygonIndex(layer) {
  const first = starts(layer.corners);
  const index = new Uint32Array(layer.triangle.length);
  let used = 0;
  for (let face = 0; face < layer.corners.length; face++) {
    const end = used + 3 * (layer.corners[face] - 2);
    for (; used < end; used++) index[used] = first[face] + layer.triangle[used];
  }
  return index;
}

// How far a block is moved where the model is taken apart; a joint stays on that which goes less far.
function awayOf(data, view, a, b = a) {
  const of = (block) => data.blocks.away.subarray(3 * block, 3 * block + 3);
  const less = vec.dot(of(a), of(a)) <= vec.dot(of(b), of(b)) ? a : b;
  return vec.scale(of(less), view.spread);
}

function colourOf(hex) {
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
}

// The colour of a share of the largest force, as components from 0 to 1.
function rampColour(stops, share) {
  const at = Math.min(1, Math.max(0, share)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(at));
  const [from, to] = [colourOf(stops[i]), colourOf(stops[i + 1])];
  return from.map((x, k) => x + (to[k] - x) * (at - i));
}

function cssColour(parts) {
  return `rgb(${parts.map((x) => Math.round(255 * x)).join(" ")})`;
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "\u00b5"], [1e-9, "n"]];

function quantity(value, unit) {
  if (!Number.isFinite(value)) return value > 0 ? "\u221e" : "\u2013";
  const size = Math.abs(value);
  if (size === 0) return `0 ${unit}`;
  const [factor, prefix] = PREFIXES.find(([f]) => size >= 0.9995 * f) ?? [1, ""];
  return `${Number((value / factor).toPrecision(3))} ${prefix}${unit}`;
}

// Masses above a tonne stay in kilograms, areas and volumes have no prefixes.
function plain(value, unit) {
  const size = Math.abs(value);
  const far = size !== 0 && (size < 1e-3 || size >= 1e7);
  return `${far ? value.toExponential(2) : Number(value.toPrecision(4))} ${unit}`;
}
