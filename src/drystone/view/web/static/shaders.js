// Shaders. Every vertex knows its block; what a block is and how it moves stands in textures.
// Edges, arrows and markers are read from textures too, by the number of the vertex: tens of
// thousands of tiny instances are slow on many machines.

const TEXTURE_WIDTH = 1024;
const RAMP_STOPS = 17;

const BLOCK_FUNCTIONS = `#version 300 es
precision highp float;
precision highp int;
uniform mat4 uProjection;
uniform highp sampler2D uMotion;   // four texels a block: centroid, translation, rotation vector, away
uniform highp usampler2D uState;
uniform float uTime;               // share of the motion, 0 to 1
uniform float uSpread;             // how far the model is taken apart

ivec2 at(int i) { return ivec2(i % ${TEXTURE_WIDTH}, i / ${TEXTURE_WIDTH}); }
vec3 motionOf(uint block, int part) { return texelFetch(uMotion, at(4 * int(block) + part), 0).xyz; }
uint stateOf(uint block) { return texelFetch(uState, at(int(block)), 0).r; }
vec3 turned(vec3 v, vec3 w) {
  float angle = length(w);
  if (angle < 1e-9) return v;
  vec3 axis = w / angle;
  return v * cos(angle) + cross(axis, v) * sin(angle) + axis * dot(axis, v) * (1.0 - cos(angle));
}
vec3 moved(vec3 p, uint block) {
  if (uTime == 0.0 && uSpread == 0.0) return p;
  vec3 c = motionOf(block, 0);
  vec3 away = uSpread * motionOf(block, 3);
  if (uTime == 0.0) return p + away;
  return c + away + uTime * motionOf(block, 1) + turned(p - c, uTime * motionOf(block, 2));
}
// A point of an interface stays between its blocks a and b, which may be none (-1).
vec3 carried(vec3 p, vec2 owner) {
  if (owner.x < 0.0 || uSpread == 0.0) return p;
  return p + 0.5 * uSpread * (motionOf(uint(owner.x), 3) + motionOf(uint(owner.y), 3));
}
bool hidden(vec2 owner) {
  return owner.x >= 0.0 && (stateOf(uint(owner.x)) == 0u || stateOf(uint(owner.y)) == 0u);
}
const vec4 NOWHERE = vec4(2.0, 2.0, 2.0, 1.0);
`;

// What lies beyond the section plane is not drawn.
const SECTION = `
uniform vec4 uSection; // normal, and its product with a point of the plane
in vec3 place;
void cut() { if (dot(uSection.xyz, place) > uSection.w) discard; }
`;

const BLOCK_VERTEX = `${BLOCK_FUNCTIONS}
uniform vec3 uStateColour[8];
uniform vec3 uSelectionColour;
uniform vec3 uLight;
uniform vec4 uEye;                 // a place, or a direction where the last number is 0
uniform int uSelected;
uniform int uHovered;
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint block;
flat out vec3 colour;
flat out uint id;
flat out uint kind;
out vec3 place;
out float rim;
void main() {
  uint state = stateOf(block);
  id = block + 1u;
  kind = state;
  vec3 n = uTime == 0.0 ? normal : turned(normal, uTime * motionOf(block, 2));
  float light = 0.58 + 0.36 * max(dot(n, uLight), 0.0) + 0.08 * n.z;
  vec3 base = uStateColour[state];
  if (int(block) == uSelected) base = mix(base, uSelectionColour, 0.75);
  else if (int(block) == uHovered) base = mix(base, uSelectionColour, 0.35);
  colour = base * light;
  place = moved(position, block);
  vec3 sight = normalize(uEye.xyz - uEye.w * place);
  rim = 1.0 - abs(dot(n, sight));
  gl_Position = state == 0u ? NOWHERE : uProjection * vec4(place, 1.0);
}`;

const BLOCK_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform float uOpacity;
uniform float uRatio;
uniform vec3 uHatch;
uniform vec3 uCutColour;
flat in vec3 colour;
flat in uint kind;
in float rim;
out vec4 result;
${SECTION}
void main() {
  cut();
  vec3 shown = colour;
  if (kind == 6u && mod(gl_FragCoord.x + gl_FragCoord.y, 9.0 * uRatio) < 3.0 * uRatio) shown = uHatch;
  // Glass: what is seen at a low angle is denser, so that outlines stay clear.
  float opacity = uOpacity < 1.0 ? min(1.0, uOpacity + 0.3 * rim * rim * rim) : 1.0;
  if (!gl_FrontFacing) { shown = uCutColour; opacity = uOpacity < 1.0 ? 0.5 * uOpacity : 1.0; }
  result = vec4(shown * opacity, opacity);
}`;

const ID_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
flat in uint id;
out uint result;
${SECTION}
void main() { cut(); result = id; }`;

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
const int END[6] = int[6](0, 1, 0, 0, 1, 1);
const float SIDE[6] = float[6](-1.0, -1.0, 1.0, 1.0, -1.0, 1.0);
`;

const EDGE_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}
uniform vec3 uStateColour[8];
uniform vec3 uEdgeColour;
uniform vec3 uFallColour;
uniform float uWidth;
uniform float uOpacity;
uniform int uSelected;
uniform int uGhost;       // only blocks that move
flat out vec4 colour;
out vec3 place;
out float dash;
void main() {
  int edge = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  vec4 first = texelFetch(uSegments, at(2 * edge), 0); // its last number is the block
  vec4 second = texelFetch(uSegments, at(2 * edge + 1), 0);
  uint block = uint(first.w);
  uint state = stateOf(block);
  vec3 from = moved(first.xyz, block);
  vec3 to = moved(second.xyz, block);
  vec4 a = uProjection * vec4(from, 1.0);
  vec4 b = uProjection * vec4(to, 1.0);
  bool selected = int(block) == uSelected;
  bool falls = state == 3u;
  bool still = length(motionOf(block, 1)) + length(motionOf(block, 2)) == 0.0;
  bool dark = dot(uStateColour[state], vec3(0.3, 0.6, 0.1)) < 0.2;
  float opacity = selected ? 1.0 : uOpacity;
  vec3 base = dark ? vec3(0.62) : uEdgeColour;
  if (falls) { base = uFallColour; opacity = max(opacity, 0.8); }
  colour = vec4(base, 1.0) * opacity;
  float width = uWidth * (selected ? 2.5 : falls && uGhost == 0 ? 1.7 : 1.0);
  bool lost = state == 0u || (uGhost == 1 && still) || clipped(a, b);
  vec4 p = END[corner] == 0 ? a : b;
  place = END[corner] == 0 ? from : to;
  vec2 d = along(a, b);
  dash = END[corner] == 0 ? 0.0 : length(d);
  gl_Position = lost ? NOWHERE : shifted(p, 0.5 * width * SIDE[corner] * across(d));
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

// Nine corners an arrow (six of the shaft, three of the head), two arrows a segment when paired.
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
  int arrow = gl_VertexID / 9;
  int corner = gl_VertexID % 9;
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
  float width = uByValue == 1 ? max(0.9 * uRatio, uWidth * value)
    : uHead > 0.0 ? uWidth * min(1.0, 0.4 + size / (60.0 * uRatio)) : uWidth;
  vec2 n = across(d);
  float head = uHead > 0.0 ? min(max(uHead, 1.6 * width), 0.6 * size) : 0.0;
  vec4 neck = shifted(tip, -d / size * head);
  neck.z = mix(base.z / base.w, tip.z / tip.w, 1.0 - head / size) * neck.w;
  if (corner < 6) {
    vec4 p = END[corner] == 0 ? base : neck;
    gl_Position = shifted(p, 0.5 * width * SIDE[corner] * n);
  } else if (corner == 6) {
    gl_Position = tip;
  } else {
    gl_Position = shifted(neck, (corner == 7 ? 0.42 : -0.42) * head * n);
  }
}`;

const FLAT_FRAGMENT = `#version 300 es
precision highp float;
flat in vec4 colour;
out vec4 result;
${SECTION}
void main() { cut(); result = colour; }`;

const POLYGON_VERTEX = `${BLOCK_FUNCTIONS}
layout(location = 0) in vec3 position;
layout(location = 1) in float value;
layout(location = 2) in vec2 owner;
layout(location = 3) in uint number;
uniform uint uPicked;              // number of the joint that is selected
flat out uint id;
flat out int chosen;
out float share;
out vec3 place;
void main() {
  id = number;
  chosen = number != 0u && number == uPicked ? 1 : 0;
  share = value;
  place = carried(position, owner);
  gl_Position = hidden(owner) ? NOWHERE : uProjection * vec4(place, 1.0);
}`;

const POLYGON_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform vec4 uColour;
uniform vec3 uSelectionColour;
uniform int uByValue;
uniform vec3 uRamp[${RAMP_STOPS}];
flat in int chosen;
in float share;
out vec4 result;
${SECTION}
void main() {
  cut();
  vec3 shown = uColour.rgb;
  if (uByValue == 1) {
    float position = clamp(share, 0.0, 1.0) * ${(RAMP_STOPS - 1).toFixed(1)};
    int i = min(int(position), ${RAMP_STOPS - 2});
    shown = mix(uRamp[i], uRamp[i + 1], position - float(i));
  }
  if (chosen == 1) shown = mix(shown, uSelectionColour, 0.6);
  result = vec4(shown * uColour.a, uColour.a);
}`;

// Six corners a marker: a square on the screen in which a disc or a diamond is drawn.
const MARKER_VERTEX = `${BLOCK_FUNCTIONS}${STRIP}
uniform float uSize;
out vec2 spot;
out vec3 place;
void main() {
  int marker = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  vec4 first = texelFetch(uSegments, at(3 * marker), 0);
  vec4 second = texelFetch(uSegments, at(3 * marker + 1), 0);
  vec2 owner = vec2(first.w, second.w);
  spot = vec2(END[corner] == 0 ? -1.0 : 1.0, SIDE[corner]);
  place = carried(first.xyz, owner);
  if (uTime > 0.0 && owner.x >= 0.0) place = moved(first.xyz, uint(owner.y));
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

// The ground: a square with a shadow that fades outwards.
const GROUND_VERTEX = `#version 300 es
precision highp float;
uniform mat4 uProjection;
uniform vec4 uSquare;              // middle x, y, height, half a side
out vec2 spot;
void main() {
  vec2 corner = vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
  spot = 0.5 + 0.5 * corner;
  gl_Position = uProjection * vec4(uSquare.xy + uSquare.w * corner, uSquare.z, 1.0);
}`;

const GROUND_FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D uShadow;
uniform vec4 uColour;
in vec2 spot;
out vec4 result;
void main() { result = uColour * texture(uShadow, spot).r; }`;
