// Blocks, their edges and the ground, drawn with WebGL2: one call for all blocks, one for all edges.

const LINE_WIDTH = 1.1; // [CSS pixels]
const DASH = 6; // [CSS pixels]

class BlockRenderer extends Graphics {
  constructor(canvas, data) {
    const options = { antialias: true, alpha: false, powerPreference: "high-performance" };
    super(canvas, options);
    this.data = data;
    this.build();
  }

  build() {
    const gl = this.gl;
    this.programs = {
      block: this.program(BLOCK_VERTEX, BLOCK_FRAGMENT),
      id: this.program(BLOCK_VERTEX, ID_FRAGMENT),
      jointId: this.program(POLYGON_VERTEX, ID_FRAGMENT),
      edge: this.program(EDGE_VERTEX, EDGE_FRAGMENT),
      arrow: this.program(ARROW_VERTEX, FLAT_FRAGMENT),
      polygon: this.program(POLYGON_VERTEX, POLYGON_FRAGMENT),
      marker: this.program(MARKER_VERTEX, MARKER_FRAGMENT),
      ground: this.program(GROUND_VERTEX, GROUND_FRAGMENT),
    };
    this.mesh = blockMesh(this.data.blocks);
    this.blockArray = this.vertexArray([
      [this.mesh.position, 3, gl.FLOAT],
      [this.mesh.normal, 4, gl.BYTE],
      [this.mesh.owner, 1, gl.UNSIGNED_INT],
    ]);
    this.blockIndex = this.indexBuffer(this.mesh.index);
    this.edges = this.segments(edgeSegments(this.data.blocks), 8);
    this.motionTexture = this.texture();
    this.stateTexture = this.texture();
    this.shadow = this.shadowTexture();
    this.layerBuffers = new Map();
    this.target = null;
    this.sortedFor = "";
    if (this.stage) this.setStage(this.stage, this.hidden);
  }

  shadowTexture() {
    const gl = this.gl;
    const { side, pixels } = shadowOf(this.data);
    const texture = this.texture(gl.LINEAR);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, SHADOW_SIZE, SHADOW_SIZE, 0, gl.RED, gl.UNSIGNED_BYTE,
      pixels);
    return { side, texture };
  }

  // Hidden blocks are drawn as those that are not placed: not at all.
  setStage(stage, hidden) {
    const gl = this.gl;
    [this.stage, this.hidden] = [stage, hidden];
    const { count, blocks } = this.data;
    const stateRows = Math.ceil(count / TEXTURE_WIDTH);
    const state = new Uint8Array(TEXTURE_WIDTH * stateRows);
    state.set(stage.state);
    for (const block of hidden) state[block] = 0;
    gl.bindTexture(gl.TEXTURE_2D, this.stateTexture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8UI, TEXTURE_WIDTH, stateRows, 0, gl.RED_INTEGER,
      gl.UNSIGNED_BYTE, state);
    this.motion = new Float32Array(16 * count);
    for (let i = 0; i < count; i++) {
      this.motion.set(blocks.centroid.subarray(3 * i, 3 * i + 3), 16 * i);
      this.motion.set(blocks.away.subarray(3 * i, 3 * i + 3), 16 * i + 12);
    }
    this.setMotion(stage.motion);
    this.sortedFor = "";
  }

  // How far blocks move: six numbers a block, or nothing.
  setMotion(motion) {
    if (!this.motion) return; // before the first stage
    for (let i = 0; i < this.data.count; i++) {
      for (let k = 0; k < 3; k++) {
        this.motion[16 * i + 4 + k] = motion ? motion[6 * i + k] : 0;
        this.motion[16 * i + 8 + k] = motion ? motion[6 * i + 3 + k] : 0;
      }
    }
    this.fillTexture(this.motionTexture, this.motion);
  }

  use({ program, at }, view) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at.uProjection, false, view.projection);
    gl.uniform1f(at.uTime ?? null, view.time);
    gl.uniform1f(at.uSpread ?? null, view.spread);
    gl.uniform4fv(at.uSection ?? null, view.section);
    gl.uniform1f(at.uRatio ?? null, view.ratio);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.motionTexture);
    gl.uniform1i(at.uMotion ?? null, 0);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.stateTexture);
    gl.uniform1i(at.uState ?? null, 1);
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform2f(at.uViewport ?? null, this.canvas.width, this.canvas.height);
    gl.uniform3fv(at.uStateColour ?? null, view.stateColours);
    gl.uniform3fv(at.uSelectionColour ?? null, view.colours.selection);
    gl.uniform1i(at.uSelected ?? null, view.selected);
    gl.uniform1i(at.uHovered ?? null, view.hovered);
    return at;
  }

  drawGround(view) {
    const gl = this.gl;
    const { program, at } = this.programs.ground;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at.uProjection, false, view.projection);
    gl.uniform4f(at.uSquare, 0, 0, -this.data.half[2], this.shadow.side);
    const strength = view.shadow;
    gl.uniform4f(at.uColour, 0, 0, 0, strength);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow.texture);
    gl.uniform1i(at.uShadow, 0);
    gl.bindVertexArray(null);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  drawBlocks(view) {
    const gl = this.gl;
    const at = this.use(this.programs.block, view);
    const solid = view.opacity >= 1;
    gl.uniform3fv(at.uLight, view.light);
    this.setEye(at, view);
    gl.uniform3fv(at.uHatch, view.hatch);
    gl.uniform3fv(at.uCutColour, view.cut);
    gl.uniform1f(at.uOpacity, view.opacity);
    if (!view.sectioned) gl.enable(gl.CULL_FACE); // the inside of a cut block is drawn as its cut
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 2);
    if (!solid) {
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      this.sortBlocks(view);
    }
    this.drawMesh();
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
  }

  setEye(at, view) {
    const far = 4 * vec.length(this.data.half);
    this.gl.uniform4fv(at.uEye, view.flat ? [...vec.scale(view.back, far), 0] : [...view.eye, 1]);
  }

  drawMesh() {
    const gl = this.gl;
    gl.bindVertexArray(this.blockArray);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.blockIndex);
    gl.drawElements(gl.TRIANGLES, this.mesh.index.length, gl.UNSIGNED_INT, 0);
  }

  // The depth of blocks without their colour, so that edges behind them can be told.
  drawDepth(view) {
    const gl = this.gl;
    const at = this.use(this.programs.block, view);
    gl.uniform1f(at.uOpacity, 1);
    gl.colorMask(false, false, false, false);
    if (!view.sectioned) gl.enable(gl.CULL_FACE);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 2);
    this.drawMesh();
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.CULL_FACE);
    gl.colorMask(true, true, true, true);
  }

  // Far blocks first, so that what shines through is in the right order.
  sortBlocks(view) {
    const key = view.back.join();
    if (key === this.sortedFor || (view.hurried && this.sortedFor)) return;
    this.sortedFor = key;
    const order = farFirst(this.data, view.back);
    const { index, indexStart } = this.mesh;
    const sorted = new Uint32Array(index.length);
    let used = 0;
    for (const block of order) {
      const part = index.subarray(indexStart[block], indexStart[block + 1]);
      sorted.set(part, used);
      used += part.length;
    }
    this.gl.bindVertexArray(null);
    this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER, this.blockIndex);
    this.gl.bufferSubData(this.gl.ELEMENT_ARRAY_BUFFER, 0, sorted);
  }

  drawEdges(view, opacity) {
    const gl = this.gl;
    const at = this.use(this.programs.edge, view);
    gl.uniform3fv(at.uEdgeColour, view.edgeColour);
    gl.uniform3fv(at.uFallColour, view.fallColour);
    gl.uniform1f(at.uWidth, LINE_WIDTH * view.ratio);
    gl.uniform1f(at.uOpacity, opacity);
    gl.uniform1i(at.uGhost, 0);
    this.setEye(at, view);
    gl.uniform1f(at.uDash, 0);
    gl.enable(gl.BLEND);
    this.drawSegments(at, this.edges, 6);
  }

  // Outlines of the blocks that move, where the motion begins or leads.
  drawGhost(view) {
    const gl = this.gl;
    const at = this.use(this.programs.edge, { ...view, time: 1 });
    gl.uniform3fv(at.uEdgeColour, view.ghostColour);
    gl.uniform3fv(at.uFallColour, view.fallColour);
    gl.uniform1f(at.uWidth, LINE_WIDTH * view.ratio);
    gl.uniform1f(at.uOpacity, 0.7 * Math.sqrt(view.fine));
    gl.uniform1i(at.uGhost, 1);
    this.setEye(at, view);
    gl.uniform1f(at.uDash, DASH * view.ratio);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    this.drawSegments(at, this.edges, 6);
    gl.depthMask(true);
  }

  drawSegments(at, { texture, count }, corners) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(at.uSegments, 2);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindVertexArray(null);
    gl.drawArrays(gl.TRIANGLES, 0, corners * count);
  }
}

// Numbers of the blocks, far ones first.
function farFirst(data, back) {
  const { centroid } = data.blocks;
  const depth = new Float32Array(data.count);
  for (let i = 0; i < depth.length; i++) {
    depth[i] = centroid[3 * i] * back[0] + centroid[3 * i + 1] * back[1] + centroid[3 * i + 2] * back[2];
  }
  return Uint32Array.from(depth.keys()).sort((a, b) => depth[a] - depth[b]);
}
