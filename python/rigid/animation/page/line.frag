#version 300 es
precision highp float;
in float strength;
uniform vec3 ink;
out vec4 painted;
void main() {
  painted = vec4(ink * strength, strength);
}
