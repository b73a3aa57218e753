// Vectors are arrays of three numbers, matrices of sixteen, column by column as WebGL has them.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (s, a) => [s * a[0], s * a[1], s * a[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => times(1 / Math.hypot(...a), a);
const radians = (degrees) => degrees * Math.PI / 180;
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** The matrix from the scene to the screen of an eye with unit axes right, up and forward. */
function toScreen(eye, right, up, forward, tangent, aspect, near, far) {
  const x = 1 / (tangent * aspect), y = 1 / tangent;
  const a = (far + near) / (far - near), b = -2 * far * near / (far - near);
  const put = (k) => [x * right[k], y * up[k], a * forward[k], forward[k]];
  const depth = dot(forward, eye);
  return [...put(0), ...put(1), ...put(2),
    -x * dot(right, eye), -y * dot(up, eye), b - a * depth, -depth];
}

/** Where a point is on the screen, in clip coordinates. */
function projected(matrix, p) {
  const row = (k) => matrix[k] * p[0] + matrix[4 + k] * p[1] + matrix[8 + k] * p[2] + matrix[12 + k];
  return [row(0), row(1), row(2), row(3)];
}
