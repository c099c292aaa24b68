// Number of what lies at a device pixel (from the lower left): block + 1, or the number of blocks
// + 1 + interface; 0 where there is nothing.
function pick(renderer, x, y, view, polygons) {
  const { gl } = renderer;
  const { width, height } = renderer.canvas;
  beginIds(renderer, [x, y, 1, 1], [width, height]);
  for (const layer of polygons) {
    renderer.use("jointId", view);
    const made = renderer.layerBuffer(layer);
    gl.bindVertexArray(made.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, made.index);
    gl.drawElements(gl.TRIANGLES, made.count, gl.UNSIGNED_INT, 0);
  }
  const found = new Uint32Array(4);
  const read = () => gl.readPixels(x, y, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, found);
  if (polygons.length) read();
  if (found[0] === 0 && view.showBlocks) {
    drawIds(renderer, view);
    read();
  }
  endIds(renderer);
  return found[0];
}

const GRAIN = 3; // [CSS pixels] between two places that are looked at
const LEAST = 4; // such places, below which nothing is seen of a block

// The middle { x, y } [CSS pixels] of what is seen of each block; only of those that are seen.
function seenBlocks(renderer, view, size) {
  const { gl } = renderer;
  const { width, height } = renderer.canvas;
  const wide = Math.min(width, Math.ceil(size.width / GRAIN));
  const high = Math.min(height, Math.ceil(size.height / GRAIN));
  beginIds(renderer, [0, 0, wide, high], [wide, high]);
  drawIds(renderer, view);
  const found = new Uint32Array(4 * wide * high);
  gl.readPixels(0, 0, wide, high, gl.RGBA_INTEGER, gl.UNSIGNED_INT, found);
  endIds(renderer);
  const sums = new Map();
  for (let i = 0; i < wide * high; i++) {
    if (found[4 * i] === 0) continue;
    const block = found[4 * i] - 1;
    if (!sums.has(block)) sums.set(block, [0, 0, 0]);
    const sum = sums.get(block);
    sum[0] += 1;
    sum[1] += i % wide;
    sum[2] += Math.floor(i / wide);
  }
  const out = new Map();
  for (const [block, [count, x, y]] of sums) {
    if (count < LEAST) continue;
    out.set(block, {
      x: ((x / count + 0.5) / wide) * size.width, y: (1 - (y / count + 0.5) / high) * size.height,
    });
  }
  return out;
}

// A picture of numbers in place of colours, of which a part is drawn.
function beginIds(renderer, part, size) {
  const { gl } = renderer;
  const { width, height } = renderer.canvas;
  if (renderer.target?.width !== width || renderer.target.height !== height) renderer.makeTarget(width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, renderer.target.frame);
  gl.viewport(0, 0, ...size);
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(...part);
  gl.depthMask(true);
  gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
  gl.clearBufferfv(gl.DEPTH, 0, [1]);
  gl.enable(gl.DEPTH_TEST);
  gl.disable(gl.BLEND);
}

function drawIds(renderer, view) {
  const { gl } = renderer;
  if (!view.sectioned) gl.enable(gl.CULL_FACE);
  renderer.use("id", view);
  for (const _ of renderer.drawMesh()); // all of it
  gl.disable(gl.CULL_FACE);
}

function endIds({ gl }) {
  gl.disable(gl.SCISSOR_TEST);
  gl.bindVertexArray(null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}
