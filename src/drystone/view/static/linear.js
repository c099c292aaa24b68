// Vectors of three numbers and 4 x 4 matrices stored column by column.

const vec = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  scale: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ],
  length: (a) => Math.hypot(a[0], a[1], a[2]),
};

// Whether a point is beyond a plane: normal, and its product with a point of the plane.
const isBeyond = (plane, p) => vec.dot(plane, p) > plane[3];

// The part of a polygon that is not beyond a plane.
function clipped(points, plane) {
  const out = [];
  points.forEach((p, i) => {
    const q = points[(i + 1) % points.length];
    if (!isBeyond(plane, p)) out.push(p);
    if (isBeyond(plane, p) === isBeyond(plane, q)) return;
    const [h, k] = [vec.dot(plane, p) - plane[3], vec.dot(plane, q) - plane[3]];
    out.push(vec.add(p, vec.scale(vec.sub(q, p), h / (h - k))));
  });
  return out;
}

function multiply(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let i = 0; i < 4; i++) sum += a[4 * i + row] * b[4 * column + i];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

function perspective(fieldOfView, aspect, near, far) {
  const f = 1 / Math.tan(fieldOfView / 2);
  const depth = 1 / (near - far);
  return new Float32Array([
    f / aspect, 0, 0, 0,
    0, f, 0, 0,
    0, 0, (near + far) * depth, -1,
    0, 0, 2 * near * far * depth, 0,
  ]);
}

// World to camera, from the camera's axes (unit, x right, y up, z towards the eye).
function lookFrom(eye, right, up, back) {
  return new Float32Array([
    right[0], up[0], back[0], 0,
    right[1], up[1], back[1], 0,
    right[2], up[2], back[2], 0,
    -vec.dot(right, eye), -vec.dot(up, eye), -vec.dot(back, eye), 1,
  ]);
}

// Parallel projection of a box `height` high.
function parallel(height, aspect, near, far) {
  const depth = 1 / (near - far);
  return new Float32Array([
    2 / (height * aspect), 0, 0, 0,
    0, 2 / height, 0, 0,
    0, 0, 2 * depth, 0,
    0, 0, (near + far) * depth, 1,
  ]);
}

// A vector turned as the smallest rotation turns unit vector `from` to unit vector `to`.
function turnedBetween(v, from, to) {
  const axis = vec.cross(from, to);
  const cosine = vec.dot(from, to);
  if (cosine < -0.999999) return [v[0], -v[1], -v[2]]; // upside down: half a turn about x
  const onto = vec.dot(axis, v) / (1 + cosine);
  return vec.add(vec.add(vec.scale(v, cosine), vec.cross(axis, v)), vec.scale(axis, onto));
}

// A vector turned by a rotation vector [rad].
function turned(v, w) {
  const angle = vec.length(w);
  if (angle < 1e-9) return Array.from(v);
  const axis = vec.scale(w, 1 / angle);
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  const along = vec.scale(axis, vec.dot(axis, v) * (1 - cosine));
  return vec.add(vec.add(vec.scale(v, cosine), vec.scale(vec.cross(axis, v), sine)), along);
}

// Place on the picture [CSS pixels] and depth of a point; null behind the eye.
function projected(matrix, p, width, height) {
  const row = (i) => matrix[i] * p[0] + matrix[4 + i] * p[1] + matrix[8 + i] * p[2] + matrix[12 + i];
  const w = row(3);
  if (w <= 1e-9) return null;
  return {
    x: (0.5 + (0.5 * row(0)) / w) * width,
    y: (0.5 - (0.5 * row(1)) / w) * height,
    depth: row(2) / w,
  };
}
