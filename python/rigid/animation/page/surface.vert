#version 300 es
// A lit surface: points of a part, turned with the body if the body carries it.
in vec3 position;
in vec3 normal;
in vec3 colour;
uniform mat3 turn;
uniform mat4 view;
out vec3 at;
out vec3 facing;
out vec3 ink;
void main() {
  at = turn * position;
  facing = turn * normal;
  ink = colour;
  gl_Position = view * vec4(at, 1.0);
}
