// Number of what lies at a device pixel (from the lower left): block + 1, or the number of blocks
// + 1 + interface; 0 where there is nothing.
function pick(renderer, x, y, view, polygons) {
  const { gl } = renderer;
  const { width, height } = renderer.canvas;
  if (!renderer.target || renderer.target.width !== width || renderer.target.height !== height) {
    renderer.makeTarget(width, height);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, renderer.target.frame);
  gl.viewport(0, 0, width, height);
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(x, y, 1, 1);
  gl.depthMask(true);
  gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
  gl.clearBufferfv(gl.DEPTH, 0, [1]);
  gl.enable(gl.DEPTH_TEST);
  gl.disable(gl.BLEND);
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
    if (!view.sectioned) gl.enable(gl.CULL_FACE);
    renderer.use("id", view);
    for (const _ of renderer.drawMesh()); // all of it
    gl.disable(gl.CULL_FACE);
    read();
  }
  gl.disable(gl.SCISSOR_TEST);
  gl.bindVertexArray(null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return found[0];
}
