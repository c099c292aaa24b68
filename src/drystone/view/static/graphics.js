// Programs, buffers and textures of WebGL2, and what is drawn to find what lies under the pointer.

const SAMPLES = 4; // a pixel of a whole picture

class Graphics {
  constructor(canvas, options) {
    this.gl = canvas.getContext("webgl2", options);
    if (!this.gl) throw new Error("no WebGL2");
    this.canvas = canvas;
  }

  // `define` is a name that the vertex shader tests with #ifdef, or nothing.
  program(vertex, fragment, define = "") {
    const gl = this.gl;
    const program = gl.createProgram();
    const defined = define ? vertex.replace("\n", `\n#define ${define}\n`) : vertex;
    for (const [kind, source] of [[gl.VERTEX_SHADER, defined], [gl.FRAGMENT_SHADER, fragment]]) {
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

  texture(filter = this.gl.NEAREST) {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_2D, name, filter);
    }
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) {
      gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
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

  segments(values, each) {
    const texture = this.texture();
    this.fillTexture(texture, values);
    return { texture, count: values.length / each };
  }

  // A buffer with several samples a pixel, in which whole pictures are drawn.
  makeSheet(width, height) {
    const gl = this.gl;
    const samples = Math.min(SAMPLES, gl.getParameter(gl.MAX_SAMPLES));
    if (!this.sheet) {
      const frame = gl.createFramebuffer();
      this.sheet = { frame, colour: gl.createRenderbuffer(), depth: gl.createRenderbuffer() };
    }
    const { frame, colour, depth } = this.sheet;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (const [part, format, slot] of [
      [colour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT],
    ]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, part);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, slot, gl.RENDERBUFFER, part);
    }
    Object.assign(this.sheet, { width, height });
  }

  forgetSheet() {
    const { frame, colour, depth } = this.sheet ?? {};
    this.gl.deleteFramebuffer(frame ?? null);
    for (const part of [colour, depth]) this.gl.deleteRenderbuffer(part ?? null);
    this.sheet = null;
  }

  // The picture of the buffer onto the canvas, which has its size.
  showSheet() {
    const gl = this.gl;
    const { frame, width, height } = this.sheet;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  makeTarget(width, height) {
    const gl = this.gl;
    if (this.target) {
      gl.deleteFramebuffer(this.target.frame);
      this.target.parts.forEach((part) => gl.deleteRenderbuffer(part));
    }
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const parts = [
      [gl.R32UI, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT],
    ].map(([format, slot]) => {
      const part = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, part);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, slot, gl.RENDERBUFFER, part);
      return part;
    });
    this.target = { frame, parts, width, height };
  }
}
