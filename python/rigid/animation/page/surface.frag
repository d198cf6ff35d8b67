#version 300 es
// Blinn-Phong with a lamp over the viewer's shoulder and light from the sky (Blinn 1977).
precision highp float;
in vec3 at;
in vec3 facing;
in vec3 ink;
uniform vec3 eye;
uniform vec3 lamp;
uniform vec3 up;
uniform float opacity;
uniform float gloss;
out vec4 painted;
void main() {
  vec3 towards = normalize(eye - at);
  vec3 n = normalize(facing);
  if (dot(n, towards) < 0.0) n = -n;
  float sky = 0.52 + 0.12 * dot(n, up);
  float diffuse = 0.48 * max(dot(n, lamp), 0.0);
  float shine = gloss * pow(max(dot(n, normalize(lamp + towards)), 0.0), 40.0);
  painted = vec4((ink * (sky + diffuse) + shine) * opacity, opacity);
}
