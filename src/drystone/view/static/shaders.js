// Shaders of areas: blocks, joints and the ground. Every vertex knows its block; what a block is and
// how it moves stands in textures.

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
#ifdef STILL
// Programs for blocks in place: a processor that draws computes both sides of each condition.
vec3 moved(vec3 p, uint block) { return p; }
vec3 turnedWith(vec3 v, uint block) { return v; }
vec3 carried(vec3 p, vec2 owner) { return p; }
bool moves(uint block) { return false; }
#else
vec3 moved(vec3 p, uint block) {
  vec3 c = motionOf(block, 0);
  vec3 away = uSpread * motionOf(block, 3);
  if (uTime == 0.0) return p + away;
  return c + away + uTime * motionOf(block, 1) + turned(p - c, uTime * motionOf(block, 2));
}
vec3 turnedWith(vec3 v, uint block) {
  return uTime == 0.0 ? v : turned(v, uTime * motionOf(block, 2));
}
bool moves(uint block) { return length(motionOf(block, 1)) + length(motionOf(block, 2)) > 0.0; }
// A point of an interface of blocks a and b, which may be none (-1), stays on the one that goes less far.
vec3 carried(vec3 p, vec2 owner) {
  if (owner.x < 0.0 || uSpread == 0.0) return p;
  vec3 a = motionOf(uint(owner.x), 3);
  vec3 b = motionOf(uint(owner.y), 3);
  return p + uSpread * (dot(a, a) <= dot(b, b) ? a : b);
}
#endif
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
uniform vec3 uStateColour[9];
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
  vec3 n = turnedWith(normal, block);
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

const ADDED_OPACITY = 0.85; // at least, of blocks that were added

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
  if (kind == 8u) opacity = max(opacity, ${ADDED_OPACITY}); // what was added
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
