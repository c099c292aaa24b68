// Shaders. Every vertex knows its block; what a block is and how it moves stands in textures.
// Edges and arrows are read from textures too, by the number of the vertex: tens of thousands of
// tiny instances are slow on many machines.

const TEXTURE_WIDTH = 1024;

const BLOCK_FUNCTIONS = `#version 300 es
precision highp float;
precision highp int;
uniform mat4 uProjection;
uniform highp sampler2D uMotion;   // three texels a block: centroid, translation, rotation vector
uniform highp usampler2D uState;
uniform float uTime;               // share of the motion, 0 to 1

ivec2 at(int i) { return ivec2(i % ${TEXTURE_WIDTH}, i / ${TEXTURE_WIDTH}); }
vec3 motionOf(uint block, int part) { return texelFetch(uMotion, at(3 * int(block) + part), 0).xyz; }
uint stateOf(uint block) { return texelFetch(uState, at(int(block)), 0).r; }
vec3 turned(vec3 v, vec3 w) {
  float angle = length(w);
  if (angle < 1e-9) return v;
  vec3 axis = w / angle;
  return v * cos(angle) + cross(axis, v) * sin(angle) + axis * dot(axis, v) * (1.0 - cos(angle));
}
vec3 moved(vec3 p, uint block) {
  if (uTime == 0.0) return p;
  vec3 c = motionOf(block, 0);
  return c + uTime * motionOf(block, 1) + turned(p - c, uTime * motionOf(block, 2));
}
const vec4 NOWHERE = vec4(2.0, 2.0, 2.0, 1.0);
`;

const BLOCK_VERTEX = `${BLOCK_FUNCTIONS}
uniform vec3 uStateColour[8];
uniform vec3 uSelectionColour;
uniform vec3 uLight;
uniform int uSelected;
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint block;
flat out vec3 colour;
flat out uint id;
void main() {
  uint state = stateOf(block);
  id = block + 1u;
  vec3 n = uTime == 0.0 ? normal : turned(normal, uTime * motionOf(block, 2));
  float light = 0.58 + 0.36 * max(dot(n, uLight), 0.0) + 0.08 * n.z;
  vec3 base = uStateColour[state];
  if (int(block) == uSelected) base = mix(base, uSelectionColour, 0.75);
  colour = base * light;
  gl_Position = state == 0u ? NOWHERE : uProjection * vec4(moved(position, block), 1.0);
}`;

const BLOCK_FRAGMENT = `#version 300 es
precision highp float;
uniform float uOpacity;
flat in vec3 colour;
out vec4 result;
void main() { result = vec4(colour * uOpacity, uOpacity); }`;

const ID_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
flat in uint id;
out uint result;
void main() { result = id; }`;

// A segment as a strip of constant width on the screen.
const STRIP = `
uniform vec2 uViewport;
uniform highp sampler2D uSegments; // two texels a segment
const float NEAR = 1e-5;
bool clipped(inout vec4 a, inout vec4 b) {
  if (a.w < NEAR && b.w < NEAR) return true;
  if (a.w < NEAR) a = mix(a, b, (NEAR - a.w) / (b.w - a.w));
  if (b.w < NEAR) b = mix(b, a, (NEAR - b.w) / (a.w - b.w));
  return false;
}
vec2 along(vec4 a, vec4 b) { return (b.xy / b.w - a.xy / a.w) * 0.5 * uViewport; }
vec4 shifted(vec4 p, vec2 pixels) { return p + vec4(2.0 * pixels / uViewport * p.w, 0.0, 0.0); }
vec2 across(vec2 d) { float l = length(d); return l > 0.0 ? vec2(-d.y, d.x) / l : vec2(0.0); }
const int END[6] = int[6](0, 1, 0, 0, 1, 1);
const float SIDE[6] = float[6](-1.0, -1.0, 1.0, 1.0, -1.0, 1.0);
`;

const EDGE_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}
uniform vec3 uStateColour[8];
uniform vec3 uEdgeColour;
uniform float uWidth;
uniform float uOpacity;
uniform int uSelected;
flat out vec4 colour;
void main() {
  int edge = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  vec4 first = texelFetch(uSegments, at(2 * edge), 0); // its last number is the block
  vec4 second = texelFetch(uSegments, at(2 * edge + 1), 0);
  uint block = uint(first.w);
  uint state = stateOf(block);
  vec4 a = uProjection * vec4(moved(first.xyz, block), 1.0);
  vec4 b = uProjection * vec4(moved(second.xyz, block), 1.0);
  bool selected = int(block) == uSelected;
  bool dark = dot(uStateColour[state], vec3(0.3, 0.6, 0.1)) < 0.2;
  float opacity = selected ? 1.0 : uOpacity;
  colour = vec4(dark ? vec3(0.62) : uEdgeColour, 1.0) * opacity;
  float width = uWidth * (selected ? 2.5 : 1.0);
  bool lost = state == 0u || clipped(a, b);
  vec4 p = END[corner] == 0 ? a : b;
  gl_Position = lost ? NOWHERE : shifted(p, 0.5 * width * SIDE[corner] * across(along(a, b)));
}`;

// Nine corners an arrow (six of the shaft, three of the head), two arrows a segment when paired.
const ARROW_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}
uniform vec4 uColour;
uniform float uWidth;
uniform float uScale;
uniform float uHead;      // [pixels], 0 for a plain line
uniform int uInward;
uniform int uPaired;
flat out vec4 colour;
void main() {
  colour = uColour;
  int arrow = gl_VertexID / 9;
  int corner = gl_VertexID % 9;
  int segment = uPaired == 1 ? arrow / 2 : arrow;
  float sign = uPaired == 1 && arrow % 2 == 1 ? -1.0 : 1.0;
  vec3 position = texelFetch(uSegments, at(2 * segment), 0).xyz;
  vec3 vector = texelFetch(uSegments, at(2 * segment + 1), 0).xyz;
  float part = uPaired == 1 ? 0.5 * sign : 1.0;
  vec4 base = uProjection * vec4(position, 1.0);
  vec4 tip = uProjection * vec4(position + part * uScale * vector, 1.0);
  if (uInward == 1) { vec4 swap = base; base = tip; tip = swap; }
  if (clipped(base, tip)) { gl_Position = NOWHERE; return; }
  vec2 d = along(base, tip);
  float size = length(d);
  if (size < 0.5) { gl_Position = NOWHERE; return; }
  vec2 n = across(d);
  float head = min(uHead, 0.6 * size);
  vec4 neck = shifted(tip, -d / size * head);
  neck.z = mix(base.z / base.w, tip.z / tip.w, 1.0 - head / size) * neck.w;
  if (corner < 6) {
    vec4 p = END[corner] == 0 ? base : neck;
    gl_Position = shifted(p, 0.5 * uWidth * SIDE[corner] * n);
  } else if (corner == 6) {
    gl_Position = tip;
  } else {
    gl_Position = shifted(neck, (corner == 7 ? 0.42 : -0.42) * head * n);
  }
}`;

const POLYGON_VERTEX = `${BLOCK_FUNCTIONS}
uniform vec4 uColour;
layout(location = 0) in vec3 position;
flat out vec4 colour;
void main() {
  colour = uColour;
  gl_Position = uProjection * vec4(position, 1.0);
}`;

const FLAT_FRAGMENT = `#version 300 es
precision highp float;
flat in vec4 colour;
out vec4 result;
void main() { result = colour; }`;
