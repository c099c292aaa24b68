// Shaders of edges, arrows, lines and markers, which are read from textures by the number of the
// vertex: tens of thousands of tiny instances are slow on many machines.

// A segment as a strip of constant width on the screen.
const STRIP = `
uniform vec2 uViewport;
uniform highp sampler2D uSegments;
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
const int END[4] = int[4](0, 1, 0, 1);
const float SIDE[4] = float[4](-1.0, -1.0, 1.0, 1.0);
`;

// How an edge looks: the colour of its lines, by the block and its state.
const EDGE_COLOUR = `
uniform vec3 uStateColour[9];
uniform vec3 uEdgeColour;
uniform vec3 uFallColour;
uniform float uOpacity;
uniform int uSelected;
uniform vec4 uEye;        // a place, or a direction where the last number is 0
vec4 colourOf(uint block, uint state) {
  bool dark = dot(uStateColour[state], vec3(0.3, 0.6, 0.1)) < 0.2;
  float opacity = int(block) == uSelected ? 1.0 : uOpacity;
  if (state == 3u) return vec4(uFallColour, 1.0) * max(opacity, 0.8);
  return vec4(dark ? vec3(0.62) : uEdgeColour, 1.0) * opacity;
}
// A little towards the eye, or sides seen at a low angle would break the line.
vec4 nearer(vec3 p) { return uProjection * vec4(p + 1e-3 * (uEye.xyz - uEye.w * p), 1.0); }
`;

const EDGE_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}${EDGE_COLOUR}
uniform float uWidth;
uniform int uGhost;       // only blocks that move
flat out vec4 colour;
out vec3 place;
out float dash;
void main() {
  int edge = gl_VertexID / 4;
  int corner = gl_VertexID % 4;
  vec4 first = texelFetch(uSegments, at(2 * edge), 0); // its last number is the block
  vec4 second = texelFetch(uSegments, at(2 * edge + 1), 0);
  uint block = uint(first.w);
  uint state = stateOf(block);
  vec3 from = moved(first.xyz, block);
  vec3 to = moved(second.xyz, block);
  vec4 a = uProjection * vec4(from, 1.0);
  vec4 b = uProjection * vec4(to, 1.0);
  bool still = uGhost == 1 && !moves(block);
  colour = colourOf(block, state);
  float width = uWidth * (int(block) == uSelected ? 2.5 : state == 3u && uGhost == 0 ? 1.7 : 1.0);
  bool lost = state == 0u || still || clipped(a, b);
  vec4 p = END[corner] == 0 ? a : b;
  place = END[corner] == 0 ? from : to;
  vec2 d = along(a, b);
  dash = END[corner] == 0 ? 0.0 : length(d);
  gl_Position = lost ? NOWHERE : shifted(p, 0.5 * width * SIDE[corner] * across(d));
  if (lost) return;
  vec4 near = nearer(place);
  gl_Position.z = near.z / near.w * gl_Position.w;
}`;

// An edge as a line of one pixel: a third of the work for a processor that draws.
const THIN_VERTEX = `${BLOCK_FUNCTIONS}${EDGE_COLOUR}
layout(location = 0) in vec4 end; // its last number is the block
flat out vec4 colour;
out vec3 place;
out float dash;
void main() {
  uint block = uint(end.w);
  uint state = stateOf(block);
  place = moved(end.xyz, block);
  colour = colourOf(block, state);
  dash = 0.0;
  gl_Position = state == 0u ? NOWHERE : nearer(place);
}`;

const EDGE_FRAGMENT = `#version 300 es
precision highp float;
uniform float uDash;      // [pixels], 0 for a whole line
flat in vec4 colour;
in float dash;
out vec4 result;
${SECTION}
void main() {
  cut();
  if (uDash > 0.0 && mod(dash, 2.0 * uDash) > uDash) discard;
  result = colour;
}`;

// Seven corners an arrow (four of the shaft, three of the head), two arrows a segment when paired;
// four corners a line.
const ARROW_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}
uniform vec4 uColour;
uniform float uWidth;
uniform float uRatio;
uniform float uScale;
uniform float uHead;      // [pixels], 0 for a plain line
uniform int uInward;
uniform int uSingle;      // ends at its point
uniform int uByValue;
flat out vec4 colour;
out vec3 place;
void main() {
  int corners = uHead > 0.0 ? 7 : 4;
  int arrow = gl_VertexID / corners;
  int corner = gl_VertexID % corners;
  bool paired = uHead > 0.0 && uSingle == 0;
  int segment = paired ? arrow / 2 : arrow;
  float sign = paired && arrow % 2 == 1 ? -1.0 : 1.0;
  vec4 first = texelFetch(uSegments, at(3 * segment), 0);
  vec4 second = texelFetch(uSegments, at(3 * segment + 1), 0);
  float value = texelFetch(uSegments, at(3 * segment + 2), 0).x;
  vec2 owner = vec2(first.w, second.w);
  vec3 position = carried(first.xyz, owner);
  vec3 vector = uScale * second.xyz;
  vec3 from = uSingle == 1 ? position - vector : position;
  vec3 to = uSingle == 1 ? position : position + (paired ? 0.5 * sign : 1.0) * vector;
  if (uInward == 1) { vec3 swap = from; from = to; to = swap; }
  place = position;
  vec4 base = uProjection * vec4(from, 1.0);
  vec4 tip = uProjection * vec4(to, 1.0);
  if (hidden(owner) || clipped(base, tip)) { gl_Position = NOWHERE; return; }
  vec2 d = along(base, tip);
  float size = length(d);
  if (size < 0.25) { gl_Position = NOWHERE; return; }
  // What is small fades, so that it never hides what is large.
  float seen = uByValue == 1 ? smoothstep(0.0, 0.06, value) * 0.85 + 0.15
    : uHead > 0.0 ? smoothstep(2.0, 14.0, size / uRatio) : 1.0;
  colour = uColour * seen;
  float width = uByValue == 1 ? max(max(1.0, 0.9 * uRatio), uWidth * value)
    : uHead > 0.0 ? uWidth * min(1.0, 0.4 + size / (60.0 * uRatio)) : uWidth;
  vec2 n = across(d);
  float head = uHead > 0.0 ? min(max(uHead, 1.6 * width), 0.6 * size) : 0.0;
  vec4 neck = shifted(tip, -d / size * head);
  neck.z = mix(base.z / base.w, tip.z / tip.w, 1.0 - head / size) * neck.w;
  if (corner < 4) {
    vec4 p = END[corner] == 0 ? base : neck;
    gl_Position = shifted(p, 0.5 * width * SIDE[corner] * n);
  } else if (corner == 4) {
    gl_Position = tip;
  } else {
    gl_Position = shifted(neck, (corner == 5 ? 0.42 : -0.42) * head * n);
  }
}`;

const FLAT_FRAGMENT = `#version 300 es
precision highp float;
flat in vec4 colour;
out vec4 result;
${SECTION}
void main() { cut(); result = colour; }`;

// Four corners a marker: a square on the screen in which a disc or a diamond is drawn.
const MARKER_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}
uniform float uSize;
out vec2 spot;
out vec3 place;
void main() {
  int marker = gl_VertexID / 4;
  int corner = gl_VertexID % 4;
  vec4 first = texelFetch(uSegments, at(3 * marker), 0);
  vec4 second = texelFetch(uSegments, at(3 * marker + 1), 0);
  vec2 owner = vec2(first.w, second.w);
  spot = vec2(END[corner] == 0 ? -1.0 : 1.0, SIDE[corner]);
  place = carried(first.xyz, owner);
  if (uTime > 0.0 && owner.x >= 0.0) { // between its two blocks, whichever of them turns
    place = 0.5 * (moved(first.xyz, uint(owner.x)) + moved(first.xyz, uint(owner.y)));
  }
  vec4 p = uProjection * vec4(place, 1.0);
  gl_Position = hidden(owner) || p.w < NEAR ? NOWHERE : shifted(p, uSize * spot);
}`;

const MARKER_FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 uColour;
uniform vec3 uOutline;
uniform int uDiamond;
in vec2 spot;
out vec4 result;
${SECTION}
void main() {
  cut();
  float r = uDiamond == 1 ? abs(spot.x) + abs(spot.y) : length(spot);
  float soft = fwidth(r);
  float inside = 1.0 - smoothstep(1.0 - soft, 1.0, r);
  if (inside <= 0.0) discard;
  vec3 shown = mix(uColour.rgb, uOutline, smoothstep(0.62, 0.62 + soft, r));
  result = vec4(shown, 1.0) * inside * uColour.a;
}`;
