#version 300 es
// A piece of a curve as a ribbon of constant width on the screen; one instance a piece.
in vec2 corner;
in vec3 begin;
in vec3 end;
uniform mat3 turn;
uniform mat4 view;
uniform vec2 pixels;
uniform float width;
uniform float pieces;
uniform float oldest;
out float strength;
void main() {
  vec4 a = view * vec4(turn * begin, 1.0);
  vec4 b = view * vec4(turn * end, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * pixels;
  along = dot(along, along) > 1e-12 ? normalize(along) : vec2(1.0, 0.0);
  vec4 here = corner.x < 0.5 ? a : b;
  vec2 aside = vec2(-along.y, along.x) * corner.y + along * (corner.x - 0.5) * 0.5;
  here.xy += aside * width / pixels * here.w;
  here.z -= 0.003 * here.w;  // curves on surfaces lie before them
  gl_Position = here;
  strength = mix(oldest, 1.0, (float(gl_InstanceID) + corner.x) / pieces);
}
