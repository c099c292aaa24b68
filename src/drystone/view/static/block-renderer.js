// Blocks, their edges and the ground, drawn with WebGL2: few calls for all blocks and all edges.

const LINE_WIDTH = 1.1; // [CSS pixels]
const DASH = 6; // [CSS pixels]
const MOST = 120000; // triangles of a call, after which another picture may be wanted
const LINE = [0, 1]; // the two ends of a line of one pixel
const QUAD = [0, 1, 2, 2, 1, 3]; // two triangles of the four corners of a strip
const ARROW = [...QUAD, 4, 5, 6]; // and the head
const SHADERS = {
  block: [BLOCK_VERTEX, BLOCK_FRAGMENT],
  id: [BLOCK_VERTEX, ID_FRAGMENT],
  jointId: [POLYGON_VERTEX, ID_FRAGMENT],
  edge: [EDGE_VERTEX, EDGE_FRAGMENT],
  thin: [THIN_VERTEX, EDGE_FRAGMENT],
  arrow: [ARROW_VERTEX, FLAT_FRAGMENT],
  polygon: [POLYGON_VERTEX, POLYGON_FRAGMENT],
  marker: [MARKER_VERTEX, MARKER_FRAGMENT],
  ground: [GROUND_VERTEX, GROUND_FRAGMENT],
};

class BlockRenderer extends Graphics {
  constructor(canvas, data) {
    // Whole pictures are drawn in a buffer with several samples a pixel, hurried ones with one.
    const options = { antialias: false, powerPreference: "high-performance" };
    super(canvas, options);
    this.data = data;
    this.build();
  }

  build() {
    const gl = this.gl;
    this.programs = new Map();
    for (const name of Object.keys(SHADERS)) this.programOf(name, true);
    for (const { index } of this.strips?.values() ?? []) gl.deleteBuffer(index);
    this.strips = new Map();
    this.forgetOuter();
    this.forgetSheet();
    this.mesh = blockMesh(this.data.blocks);
    this.blockArray = this.vertexArray([
      [this.mesh.position, 3, gl.FLOAT],
      [this.mesh.normal, 4, gl.BYTE],
      [this.mesh.owner, 1, gl.UNSIGNED_INT],
    ]);
    this.blockIndex = this.indexBuffer(this.mesh.index);
    const segments = edgeSegments(this.data.blocks);
    this.edges = this.segments(segments, 8);
    this.ends = this.vertexArray([[segments, 4, gl.FLOAT]]);
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
    if (state.some((one, block) => one !== this.state?.[block])) this.forgetOuter();
    this.state = state;
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

  // A program by its name; where no block moves a shorter one does.
  programOf(name, still) {
    const key = `${name} ${still}`;
    if (!this.programs.has(key)) {
      this.programs.set(key, this.program(...SHADERS[name], still ? "STILL" : ""));
    }
    return this.programs.get(key);
  }

  use(name, view) {
    const gl = this.gl;
    const { program, at } = this.programOf(name, view.time === 0 && view.spread === 0);
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
    gl.uniform2f(at.uViewport ?? null, view.width, view.height);
    gl.uniform3fv(at.uStateColour ?? null, view.stateColours);
    gl.uniform3fv(at.uSelectionColour ?? null, view.colours.selection);
    gl.uniform1i(at.uSelected ?? null, view.selected);
    gl.uniform1i(at.uHovered ?? null, view.hovered);
    return at;
  }

  drawGround(view) {
    const gl = this.gl;
    const { program, at } = this.programOf("ground", true);
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

  * drawBlocks(view) {
    const gl = this.gl;
    const at = this.use("block", view);
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
      if (!view.hurried) this.sortBlocks(view);
    }
    const part = view.coarse ? this.outerOf(view)?.triangles : null;
    yield* part ? this.drawIndices(this.blockArray, part) : this.drawMesh();
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
  }

  // What is seen of opaque blocks, or null where blocks are apart, move or are cut. Where corners lie
  // on edges of other blocks, tiny holes remain between the faces: whole pictures have all faces.
  outerOf(view) {
    if (view.time !== 0 || view.spread !== 0 || view.sectioned) return null;
    if (!this.outer) {
      const faces = outerFaces(this.data, this.mesh, this.state);
      const buffer = (index) => ({ index: this.indexBuffer(index), count: index.length });
      const edges = outerEdges(this.data, faces);
      this.outer = {
        triangles: buffer(outerTriangles(this.data, this.mesh, faces)),
        edges: buffer(stripIndices(edges, QUAD)),
        lines: buffer(stripIndices(edges, LINE)),
      };
    }
    return this.outer;
  }

  forgetOuter() {
    for (const { index } of Object.values(this.outer ?? {})) this.gl.deleteBuffer(index);
    this.outer = null;
  }

  setEye(at, view) {
    const far = 4 * vec.length(this.data.half);
    this.gl.uniform4fv(at.uEye, view.flat ? [...vec.scale(view.back, far), 0] : [...view.eye, 1]);
  }

  drawMesh() {
    return this.drawIndices(this.blockArray, { index: this.blockIndex, count: this.mesh.index.length });
  }

  // In calls between which one can stop; vertices of no array are known by their numbers alone.
  * drawIndices(array, { index, count }, mode = this.gl.TRIANGLES) {
    const gl = this.gl;
    for (let from = 0; from < count; from += 3 * MOST) {
      if (from > 0) yield;
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
      gl.drawElements(mode, Math.min(3 * MOST, count - from), gl.UNSIGNED_INT, 4 * from);
    }
  }

  // The depth of blocks without their colour, so that edges behind them can be told.
  * drawDepth(view) {
    const gl = this.gl;
    const at = this.use("block", view);
    gl.uniform1f(at.uOpacity, 1);
    gl.colorMask(false, false, false, false);
    if (!view.sectioned) gl.enable(gl.CULL_FACE);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 2);
    const part = this.outerOf(view)?.triangles;
    yield* part ? this.drawIndices(this.blockArray, part) : this.drawMesh();
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.CULL_FACE);
    gl.colorMask(true, true, true, true);
  }

  // Far blocks first, so that what shines through is in the right order.
  sortBlocks(view) {
    const key = view.back.join();
    if (key === this.sortedFor) return;
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

  // Of opaque blocks the `outer` edges.
  * drawEdges(view, opacity, outer) {
    const gl = this.gl;
    const at = this.use(view.sharp ? "thin" : "edge", view);
    gl.uniform3fv(at.uEdgeColour, view.edgeColour);
    gl.uniform3fv(at.uFallColour, view.fallColour);
    gl.uniform1f(at.uWidth ?? null, Math.max(1, LINE_WIDTH * view.ratio)); // pixels: thinner lines are broken
    gl.uniform1f(at.uOpacity, opacity);
    gl.uniform1i(at.uGhost ?? null, 0);
    this.setEye(at, view);
    gl.uniform1f(at.uDash, 0);
    gl.enable(gl.BLEND);
    const part = outer ? this.outerOf(view) : null;
    if (!view.sharp) yield* this.drawSegments(at, this.edges, QUAD, 1, part?.edges);
    else {
      const { count } = this.edges;
      const all = () => ({ index: this.stripBuffer(LINE, count), count: LINE.length * count });
      yield* this.drawIndices(this.ends, part?.lines ?? all(), gl.LINES);
    }
  }

  // Outlines of the blocks that move, where the motion begins or leads.
  * drawGhost(view) {
    const gl = this.gl;
    const at = this.use("edge", { ...view, time: 1 });
    gl.uniform3fv(at.uEdgeColour, view.ghostColour);
    gl.uniform3fv(at.uFallColour, view.fallColour);
    gl.uniform1f(at.uWidth, Math.max(1, LINE_WIDTH * view.ratio));
    gl.uniform1f(at.uOpacity, 0.7 * Math.sqrt(view.fine));
    gl.uniform1i(at.uGhost, 1);
    this.setEye(at, view);
    gl.uniform1f(at.uDash, DASH * view.ratio);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    yield* this.drawSegments(at, this.edges, QUAD);
    gl.depthMask(true);
  }

  // `each` shapes a segment, of all segments or of those with the indices of `part`.
  drawSegments(at, { texture, count }, shape, each = 1, part = null) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(at.uSegments, 2);
    gl.activeTexture(gl.TEXTURE0);
    const index = part?.index ?? this.stripBuffer(shape, each * count);
    return this.drawIndices(null, { index, count: part?.count ?? shape.length * each * count });
  }

  // Indices of at least so many shapes.
  stripBuffer(shape, count) {
    const known = this.strips.get(shape);
    if (known && known.count >= count) return known.index;
    if (known) this.gl.deleteBuffer(known.index);
    const index = this.indexBuffer(stripIndices(Uint32Array.from({ length: count }, (_, i) => i), shape));
    this.strips.set(shape, { index, count });
    return index;
  }
}

// Indices of the corners of shapes, each of which has its own corners.
function stripIndices(numbers, shape) {
  const corners = Math.max(...shape) + 1;
  const index = new Uint32Array(shape.length * numbers.length);
  for (let i = 0; i < numbers.length; i++) {
    for (let k = 0; k < shape.length; k++) index[shape.length * i + k] = corners * numbers[i] + shape[k];
  }
  return index;
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
