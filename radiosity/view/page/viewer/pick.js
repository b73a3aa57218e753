// Which point of the surfaces is clicked on, and what is known of it.

/** The nearest triangle of some parts that a ray meets from its front, with the weights of its corners. */
function hit(points, triangles, parts, origin, direction) {
  let nearest = null;
  for (const part of parts) nearest = hitPart(points, triangles, part, origin, direction, nearest);
  return nearest;
}

/** The nearest triangle of a part that a ray meets before `found`, or `found`. */
function hitPart(points, triangles, part, origin, direction, found) {
  const [ox, oy, oz] = origin, [dx, dy, dz] = direction;
  let nearest = found ? found.length : Infinity;
  for (let t = part.start; t < part.start + part.count; t += 3) {
    const i = 3 * triangles[t], j = 3 * triangles[t + 1], k = 3 * triangles[t + 2];
    const ax = points[j] - points[i], ay = points[j + 1] - points[i + 1], az = points[j + 2] - points[i + 2];
    const bx = points[k] - points[i], by = points[k + 1] - points[i + 1], bz = points[k + 2] - points[i + 2];
    const px = dy * bz - dz * by, py = dz * bx - dx * bz, pz = dx * by - dy * bx;
    const determinant = ax * px + ay * py + az * pz;
    if (!(determinant > 0)) continue; // seen from behind, or edge-on
    const rx = ox - points[i], ry = oy - points[i + 1], rz = oz - points[i + 2];
    const u = (rx * px + ry * py + rz * pz) / determinant;
    if (u < 0 || u > 1) continue;
    const qx = ry * az - rz * ay, qy = rz * ax - rx * az, qz = rx * ay - ry * ax;
    const v = (dx * qx + dy * qy + dz * qz) / determinant;
    if (v < 0 || u + v > 1) continue;
    const length = (bx * qx + by * qy + bz * qz) / determinant;
    if (length > 0 && length < nearest) {
      nearest = length;
      found = { first: t, length, share: [1 - u - v, u, v], point: add(origin, times(length, direction)) };
    }
  }
  return found;
}

/** The unit normal of a triangle, on the side that is shown. */
function normalOf(arrays, first) {
  const [a, b, c] = [0, 1, 2].map((k) => {
    const at = 3 * arrays.triangles[first + k];
    return Array.from(arrays.points.subarray(at, at + 3));
  });
  return unit(cross(subtract(b, a), subtract(c, a)));
}

const NEAR = 1e-4; // of the way to a point: what is met within it is the point's own surface

/** Whether an eye cannot see a point that was hit: all but clear things are before it, or its back. */
function hidden(about, arrays, eye, found) {
  const way = subtract(found.point, eye);
  if (dot(way, normalOf(arrays, found.first)) >= 0) return true;
  const solid = about.parts.filter((p) => about.materials[p.material].opacity === 1);
  const met = hit(arrays.points, arrays.triangles, solid, eye, way);
  return met !== null && met.length < 1 - NEAR;
}

/** What is known of a point that was hit, under the light of `weights`. */
function known(about, arrays, light, weights, found) {
  const corners = [0, 1, 2].map((c) => arrays.triangles[found.first + c]);
  const at = (values, width, c) => corners.reduce(
    (sum, corner, k) => sum + found.share[k] * values[width * corner + c], 0);
  const part = about.parts.find((p) => found.first >= p.start && found.first < p.start + p.count);
  const material = about.materials[part.material];
  const reflected = [1, 2, 3].map((c) => at(light, 4, c));
  const sent = add(part.back ? [0, 0, 0] : emitted(material, weights), reflected);
  const lux = at(light, 4, 0), even = weights.every((w) => w === weights[0]);
  return {
    lux, material,
    error: even && arrays.error ? weights[0] * at(arrays.error[0], 1, 0) : null,
    estimated: Boolean(arrays.error),
    luminance: about.efficacy * dot(sent, [0.2126, 0.7152, 0.0722]) / Math.PI,
    reflectance: material.reflectance[part.back],
    side: part.back ? 'back' : 'front',
    point: found.point,
    normal: normalOf(arrays, found.first),
    textured: Boolean(material.picture),
  };
}
