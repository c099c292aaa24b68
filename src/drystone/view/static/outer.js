// Faces and edges on the outside of the blocks: all that is seen of opaque blocks in place.

const COVERED = 0.999; // share of the area of a face from which on its contacts cover it
const FLUSH = 1e-3; // by the size of a block: so near to the plane of a face a contact lies in it
const SAME_WAY = 1 - 1e-4; // cosine between the normals of a face and of a contact in it

// The face of block a and that of block b in which each contact lies; -1 where there is not just one.
function facesOfContacts(data, mesh, vectors) {
  const { a, b, frame, centroid } = data.contacts;
  const first = starts(data.blocks.faces);
  const corner = starts(data.blocks.corners);
  const found = new Int32Array(2 * a.length).fill(-1);
  const near = FLUSH * data.blockSize;
  for (let i = 0; i < a.length; i++) {
    for (const [side, block, sign] of [[0, a[i], 1], [1, b[i], -1]]) {
      let [face, many] = [-1, false];
      for (let f = first[block]; f < first[block + 1]; f++) {
        let [along, off] = [0, 0];
        for (let k = 0; k < 3; k++) {
          const n = sign * frame[9 * i + k];
          along += n * vectors[f][k];
          off += n * (mesh.position[3 * corner[f] + k] - centroid[3 * i + k]);
        }
        if (along < SAME_WAY * vec.length(vectors[f]) || Math.abs(off) > near) continue;
        [face, many] = [f, face >= 0];
      }
      if (!many) found[2 * i + side] = face;
    }
  }
  return found;
}

// Whether each face is seen from outside, where some blocks are absent (state 0).
function outerFaces(data, mesh, state) {
  const corner = starts(data.blocks.corners);
  mesh.vectors ??= Array.from(data.blocks.corners, (_, face) => (
    areaVector(mesh.position, corner[face], corner[face + 1])
  ));
  mesh.faceOf ??= facesOfContacts(data, mesh, mesh.vectors);
  const whole = Float32Array.from(mesh.vectors, (vector) => 0.5 * vec.length(vector));
  const left = whole.slice();
  const { a, b, area } = data.contacts;
  for (let i = 0; i < a.length; i++) {
    if (state[a[i]] === 0 || state[b[i]] === 0) continue;
    for (const face of mesh.faceOf.subarray(2 * i, 2 * i + 2)) if (face >= 0) left[face] -= area[i];
  }
  return Uint8Array.from(left, (x, face) => Number(x > (1 - COVERED) * whole[face]));
}

// Triangles of the outer faces; indices of corners.
function outerTriangles(data, mesh, outer) {
  const index = [];
  let used = 0;
  data.blocks.corners.forEach((corners, face) => {
    const end = used + 3 * (corners - 2);
    if (outer[face]) for (let i = used; i < end; i++) index.push(mesh.index[i]);
    used = end;
  });
  return Uint32Array.from(index);
}

// Numbers of the edges of outer faces.
function outerEdges(data, outer) {
  const { faces, corners, loop, edge, edges, points } = data.blocks;
  const kept = [];
  let [face, corner, e] = [0, 0, 0];
  for (let block = 0; block < data.count; block++) {
    const seen = new Set();
    const key = (p, q) => Math.min(p, q) * points[block] + Math.max(p, q);
    for (let f = 0; f < faces[block]; f++, face++) {
      const size = corners[face];
      for (let k = 0; outer[face] && k < size; k++) {
        seen.add(key(loop[corner + k], loop[corner + ((k + 1) % size)]));
      }
      corner += size;
    }
    for (let k = 0; k < edges[block]; k++, e++) {
      if (seen.has(key(edge[2 * e], edge[2 * e + 1]))) kept.push(e);
    }
  }
  return Uint32Array.from(kept);
}
