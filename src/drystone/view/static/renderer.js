// The whole picture: layers of forces and marks, in front of, between and behind the blocks.

const NETWORK_WIDTH = 7; // [CSS pixels], of the largest force
const HEAD = 9; // [CSS pixels], length of an arrow's head
const HIDDEN = 0.75; // opacity of what lies behind opaque blocks: arrows of help end inside them
const BEHIND = 0.16; // opacity of edges behind glassy blocks
const UNSEEN = 0.06; // opacity of lines below which nobody sees them

class Renderer extends BlockRenderer {
  layerBuffer(layer) {
    if (this.layerBuffers.has(layer)) return this.layerBuffers.get(layer);
    const gl = this.gl;
    const { contacts, count } = this.data;
    let made;
    if (layer.kind === "polygons") {
      const index = polygonIndex(layer);
      const { value, owner, number } = polygonCorners(layer, contacts, count + 1);
      made = { count: index.length };
      made.array = this.vertexArray([
        [layer.position, 3, gl.FLOAT], [value, 1, gl.FLOAT], [owner, 2, gl.FLOAT],
        [number, 1, gl.UNSIGNED_INT],
      ]);
      made.index = this.indexBuffer(index);
    } else {
      made = this.segments(vectorSegments(layer, contacts), 12);
    }
    this.layerBuffers.set(layer, made);
    return made;
  }

  // The picture at once, on the canvas, which has its size. view: see currentView() in drawing.js.
  draw(view) {
    if (view.hurried) {
      this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, null);
      for (const _ of this.steps(view)); // all of them
    } else {
      for (const _ of this.whole(view)); // all of them
      this.showSheet();
    }
  }

  // The whole picture in the buffer, in steps after which other things may be drawn.
  * whole(view) {
    const gl = this.gl;
    if (this.sheet?.width !== view.width || this.sheet?.height !== view.height) {
      this.makeSheet(view.width, view.height);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.sheet.frame);
    yield* this.steps(view);
  }

  * steps(view) {
    const gl = this.gl;
    gl.viewport(0, 0, view.width, view.height);
    gl.clearColor(...view.colours.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    if (view.showGround) this.drawGround(view);
    if (view.showBlocks && view.opacity >= 1) yield* this.drawSolid(view);
    else yield* this.drawGlass(view);
    if (view.showGhost) yield* this.drawGhost(view);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }

  // Blocks hide what is behind them; of forces behind them a trace is left.
  * drawSolid(view) {
    const gl = this.gl;
    yield* this.drawBlocks(view);
    if (view.showEdges) yield* this.drawEdges(view, view.fine, true);
    gl.enable(gl.BLEND);
    for (const layer of view.layers) {
      const seen = layer.over ? this.nearer(view) : view; // than the edges of blocks, which they lie in
      gl.depthMask(false);
      gl.depthFunc(gl.GREATER);
      yield* this.drawLayer(layer, seen, layer.kind === "polygons" ? 0.2 : HIDDEN);
      gl.depthFunc(gl.LEQUAL);
      yield* this.drawLayer(layer, seen, 1);
      gl.depthMask(true);
    }
  }

  // Forces first, then blocks like glass over them, then their edges, faint behind and clear in
  // front, then marks and arrows.
  * drawGlass(view) {
    const gl = this.gl;
    const inside = view.layers.filter(({ kind, value, over }) => kind === "polygons" || (value && !over));
    for (const layer of inside.filter(({ kind }) => kind === "polygons")) {
      yield* this.drawLayer(layer, view, 1);
    }
    gl.enable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST); // joints would cut the lines of forces into dashes
    for (const layer of inside.filter(({ kind }) => kind !== "polygons")) {
      yield* this.drawLayer(layer, view, 1);
    }
    gl.enable(gl.DEPTH_TEST);
    if (view.showBlocks) yield* this.drawBlocks(view);
    const behind = BEHIND * view.fine > UNSEEN && !view.sharp; // a third of a sharp picture
    if (view.showEdges && (behind || !view.showBlocks)) {
      gl.depthMask(false);
      yield* this.drawEdges(view, BEHIND * view.fine, false);
    }
    if (view.showEdges && view.showBlocks) {
      gl.depthMask(true);
      yield* this.drawDepth(view);
      gl.depthMask(false);
      yield* this.drawEdges(view, 0.75 * view.fine, true);
    }
    gl.depthMask(false);
    gl.disable(gl.DEPTH_TEST);
    for (const layer of view.layers.filter((one) => !inside.includes(one))) {
      yield* this.drawLayer(layer, view, 1);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
  }

  // A parallel view in which all lies a little nearer to the eye, by twice as much as edges do.
  nearer(view) {
    const projection = view.projection.slice();
    const way = vec.scale(view.back, 8e-3 * vec.length(this.data.half));
    for (let k = 0; k < 3; k++) projection[14] += way[k] * projection[4 * k + 2];
    return { ...view, projection };
  }

  * drawLayer(layer, view, opacity) {
    const gl = this.gl;
    const made = this.layerBuffer(layer);
    const colour = view.colours[layer.colour];
    const premultiplied = [...colour.map((c) => c * opacity), opacity];
    if (layer.kind === "polygons") {
      const at = this.use("polygon", view);
      gl.uniform4f(at.uColour, ...colour, opacity);
      gl.uniform1i(at.uByValue, layer.value ? 1 : 0);
      gl.uniform3fv(at.uRamp, view.ramp);
      gl.uniform1ui(at.uPicked, view.joint < 0 ? 0 : this.data.count + 1 + view.joint);
      yield* this.drawIndices(made.array, made);
      return;
    }
    if (layer.kind === "markers") {
      const at = this.use("marker", view);
      gl.uniform1f(at.uSize, view.markerSize * view.ratio);
      gl.uniform4f(at.uColour, ...colour, opacity);
      gl.uniform3fv(at.uOutline, view.outline);
      gl.uniform1i(at.uDiamond, layer.shape === "diamond" ? 1 : 0);
      yield* this.drawSegments(at, made, QUAD);
      return;
    }
    const at = this.use("arrow", view);
    const arrows = layer.kind === "arrows";
    const width = layer.value ? NETWORK_WIDTH : 1.4 * LINE_WIDTH;
    gl.uniform4f(at.uColour, ...premultiplied);
    gl.uniform1f(at.uWidth, Math.max(view.hurried ? 1 : 0, width * layer.width * view.fine * view.ratio));
    gl.uniform1f(at.uScale, arrows ? layer.scale * view.stretch : 1);
    gl.uniform1f(at.uHead, arrows ? HEAD * Math.sqrt(layer.width) * view.fine * view.ratio : 0);
    gl.uniform1i(at.uInward, layer.inward ? 1 : 0);
    gl.uniform1i(at.uSingle, layer.single ? 1 : 0);
    gl.uniform1i(at.uByValue, layer.value ? 1 : 0);
    yield* this.drawSegments(at, made, arrows ? ARROW : QUAD, arrows && !layer.single ? 2 : 1);
  }
}
