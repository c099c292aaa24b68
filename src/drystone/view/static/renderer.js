// Drawing with WebGL2: one call for all blocks, one for all edges, one or two a layer.

const LINE_WIDTH = 1.1; // [CSS pixels]
const HEAD = 9; // [CSS pixels], length of an arrow's head
const HIDDEN = 0.45; // opacity of what lies behind blocks

class Renderer {
  constructor(canvas, data) {
    const options = { antialias: true, alpha: false, powerPreference: "high-performance" };
    this.gl = canvas.getContext("webgl2", options);
    if (!this.gl) throw new Error("no WebGL2");
    this.canvas = canvas;
    this.data = data;
    this.build();
  }

  build() {
    const gl = this.gl;
    this.programs = {
      block: this.program(BLOCK_VERTEX, BLOCK_FRAGMENT),
      id: this.program(BLOCK_VERTEX, ID_FRAGMENT),
      edge: this.program(EDGE_VERTEX, FLAT_FRAGMENT),
      arrow: this.program(ARROW_VERTEX, FLAT_FRAGMENT),
      polygon: this.program(POLYGON_VERTEX, FLAT_FRAGMENT),
    };
    this.mesh = blockMesh(this.data.blocks);
    this.blockArray = this.vertexArray([
      [this.mesh.position, 3, gl.FLOAT],
      [this.mesh.normal, 4, gl.BYTE],
      [this.mesh.owner, 1, gl.UNSIGNED_INT],
    ]);
    this.blockIndex = this.indexBuffer(this.mesh.index);
    this.edges = this.segments(edgeSegments(this.data.blocks));
    this.motionTexture = this.texture();
    this.stateTexture = this.texture();
    this.layerBuffers = new Map();
    this.sortedFor = "";
    if (this.stage) this.setStage(this.stage);
  }

  program(vertex, fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
        throw new Error(gl.getShaderInfoLog(shader));
      }
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new Error(gl.getProgramInfoLog(program));
    }
    const at = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) ?? 0;
    for (let i = 0; i < count; i++) {
      const { name } = gl.getActiveUniform(program, i);
      at[name.replace("[0]", "")] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }

  vertexArray(attributes) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    attributes.forEach(([values, size, type], location) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(location);
      if (type === gl.UNSIGNED_INT) gl.vertexAttribIPointer(location, size, type, 0, 0);
      else gl.vertexAttribPointer(location, size, type, type === gl.BYTE, 0, 0);
    });
    gl.bindVertexArray(null);
    return array;
  }

  indexBuffer(values) {
    const gl = this.gl;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    return buffer;
  }

  texture() {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    }
    return texture;
  }

  // Fills a texture of four numbers a texel; values are padded to whole rows.
  fillTexture(texture, values) {
    const gl = this.gl;
    const rows = Math.max(1, Math.ceil(values.length / (4 * TEXTURE_WIDTH)));
    const padded = new Float32Array(4 * TEXTURE_WIDTH * rows);
    padded.set(values);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, TEXTURE_WIDTH, rows, 0, gl.RGBA, gl.FLOAT, padded);
  }

  segments(values) {
    const texture = this.texture();
    this.fillTexture(texture, values);
    return { texture, count: values.length / 8 };
  }

  setStage(stage) {
    const gl = this.gl;
    this.stage = stage;
    const { count, blocks } = this.data;
    const stateRows = Math.ceil(count / TEXTURE_WIDTH);
    const state = new Uint8Array(TEXTURE_WIDTH * stateRows);
    state.set(stage.state);
    gl.bindTexture(gl.TEXTURE_2D, this.stateTexture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8UI, TEXTURE_WIDTH, stateRows, 0, gl.RED_INTEGER,
      gl.UNSIGNED_BYTE, state);
    const motion = new Float32Array(12 * count);
    for (let i = 0; i < count; i++) {
      motion.set(blocks.centroid.subarray(3 * i, 3 * i + 3), 12 * i);
      if (stage.motion) {
        motion.set(stage.motion.subarray(6 * i, 6 * i + 3), 12 * i + 4);
        motion.set(stage.motion.subarray(6 * i + 3, 6 * i + 6), 12 * i + 8);
      }
    }
    this.fillTexture(this.motionTexture, motion);
    this.sortedFor = "";
  }

  layerBuffer(layer) {
    if (this.layerBuffers.has(layer)) return this.layerBuffers.get(layer);
    const gl = this.gl;
    let made;
    if (layer.kind === "polygons") {
      const index = polygonIndex(layer);
      made = { array: this.vertexArray([[layer.position, 3, gl.FLOAT]]), count: index.length };
      made.index = this.indexBuffer(index);
    } else {
      made = this.segments(vectorSegments(layer));
    }
    this.layerBuffers.set(layer, made);
    return made;
  }

  use({ program, at }, view) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at.uProjection, false, view.projection);
    gl.uniform1f(at.uTime ?? null, view.time);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.motionTexture);
    gl.uniform1i(at.uMotion ?? null, 0);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.stateTexture);
    gl.uniform1i(at.uState ?? null, 1);
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform2f(at.uViewport ?? null, this.canvas.width, this.canvas.height);
    gl.uniform3fv(at.uStateColour ?? null, view.stateColours);
    gl.uniform1i(at.uSelected ?? null, view.selected);
    return at;
  }

  // view: projection, back (towards the eye), light, time, opacity, scale, ratio (device pixels),
  // fine (thinner lines for small blocks), selected, showBlocks, showEdges, layers (those to draw), stateColours, colours
  draw(view) {
    const gl = this.gl;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...view.colours.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    if (view.showBlocks) this.drawBlocks(view);
    if (view.showEdges) this.drawEdges(view);
    if (view.time === 0) {
      for (const layer of view.layers) this.drawLayer(layer, view);
    }
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }

  drawBlocks(view) {
    const gl = this.gl;
    const at = this.use(this.programs.block, view);
    const solid = view.opacity >= 1;
    gl.uniform3fv(at.uLight, view.light);
    gl.uniform3fv(at.uSelectionColour, view.colours.selection);
    gl.uniform1f(at.uOpacity, view.opacity);
    gl.enable(gl.CULL_FACE);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 2);
    if (!solid) {
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      this.sortBlocks(view);
    }
    gl.bindVertexArray(this.blockArray);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.blockIndex);
    gl.drawElements(gl.TRIANGLES, this.mesh.index.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
  }

  // Far blocks first, so that what shines through is in the right order.
  sortBlocks(view) {
    const key = view.back.join();
    if (key === this.sortedFor) return;
    this.sortedFor = key;
    const { centroid } = this.data.blocks;
    const depth = new Float32Array(this.data.count);
    for (let i = 0; i < depth.length; i++) {
      depth[i] = vec.dot(centroid.subarray(3 * i, 3 * i + 3), view.back);
    }
    const order = Uint32Array.from(depth.keys()).sort((a, b) => depth[a] - depth[b]);
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

  drawEdges(view) {
    const gl = this.gl;
    const at = this.use(this.programs.edge, view);
    gl.uniform3fv(at.uEdgeColour, view.edgeColour);
    gl.uniform1f(at.uWidth, LINE_WIDTH * view.ratio);
    gl.uniform1f(at.uOpacity, view.fine * (view.showBlocks ? Math.max(view.opacity, 0.25) : 0.7));
    gl.enable(gl.BLEND);
    this.drawSegments(at, this.edges, 6);
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

  // Twice: what is behind blocks faintly, what is in front fully.
  drawLayer(layer, view) {
    const gl = this.gl;
    const made = this.layerBuffer(layer);
    const flat = layer.kind === "polygons";
    const at = this.use(flat ? this.programs.polygon : this.programs.arrow, view);
    const colour = view.colours[layer.colour];
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    if (!flat) {
      const arrows = layer.kind === "arrows";
      gl.uniform1f(at.uWidth, LINE_WIDTH * layer.width * view.fine * view.ratio);
      gl.uniform1f(at.uScale, arrows ? view.scale : 1);
      gl.uniform1f(at.uHead, arrows ? HEAD * Math.sqrt(layer.width) * view.fine * view.ratio : 0);
      gl.uniform1i(at.uInward, layer.inward ? 1 : 0);
      gl.uniform1i(at.uPaired, arrows ? 1 : 0);
    }
    for (const [compare, strength] of [[gl.GREATER, HIDDEN], [gl.LEQUAL, 1]]) {
      const opacity = strength * (flat ? 0.75 : 1);
      gl.depthFunc(compare);
      gl.uniform4f(at.uColour, ...colour.map((c) => c * opacity), opacity);
      if (flat) {
        gl.bindVertexArray(made.array);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, made.index);
        gl.drawElements(gl.TRIANGLES, made.count, gl.UNSIGNED_INT, 0);
      } else {
        this.drawSegments(at, made, layer.kind === "arrows" ? 18 : 9);
      }
    }
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(true);
  }

  // Number of the block at a device pixel (from the lower left), -1 where there is none.
  pick(x, y, view) {
    const gl = this.gl;
    const { width, height } = this.canvas;
    const target = gl.createFramebuffer();
    const ids = gl.createRenderbuffer();
    const depth = gl.createRenderbuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    for (const [buffer, format, slot] of [
      [ids, gl.R32UI, gl.COLOR_ATTACHMENT0],
      [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT],
    ]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, slot, gl.RENDERBUFFER, buffer);
    }
    gl.viewport(0, 0, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(x, y, 1, 1);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    this.use(this.programs.id, view);
    gl.bindVertexArray(this.blockArray);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.blockIndex);
    gl.drawElements(gl.TRIANGLES, this.mesh.index.length, gl.UNSIGNED_INT, 0);
    const found = new Uint32Array(4);
    gl.readPixels(x, y, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, found);
    gl.disable(gl.SCISSOR_TEST);
    gl.disable(gl.CULL_FACE);
    gl.bindVertexArray(null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(ids);
    gl.deleteRenderbuffer(depth);
    return found[0] - 1;
  }
}
