// The mesh and its light, as radiosity/view/page/packing.py packed them.

/** What each of the 65536 half floats stands for. */
function halfFloats() {
  const found = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const power = (bits >> 10) & 31, part = bits & 1023;
    const size = power === 0 ? part * 2 ** -24 : (1 + part / 1024) * 2 ** (power - 15);
    found[bits] = bits & 32768 ? -size : size;
  }
  return found;
}

/** Bytes of numbers, `width` each, of which the first bytes of all come first. */
function together(bytes, width) {
  const count = bytes.length / width, found = new Uint8Array(bytes.length);
  for (let b = 0; b < width; b++) {
    for (let k = 0; k < count; k++) found[k * width + b] = bytes[b * count + k];
  }
  return found.buffer;
}

function unpacked(entry, bytes) {
  if (entry.kind === 'float32') return new Float32Array(together(bytes, 4));
  if (entry.kind === 'int32') {
    const steps = new Int32Array(together(bytes, 4));
    for (let k = 1; k < steps.length; k++) steps[k] += steps[k - 1];
    return new Uint32Array(steps.buffer);
  }
  const halves = new Uint16Array(together(bytes, 2)), table = halfFloats(), count = entry.shape[1];
  return entry.scale.map((scale, row) => {
    const found = new Float32Array(count);
    for (let k = 0; k < count; k++) found[k] = scale * table[halves[row * count + k]];
    return found;
  });
}

/** The arrays of a page by their names. */
async function readArrays(text, entries) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const found = {};
  let at = 0;
  for (const [name, entry] of Object.entries(entries)) {
    const width = entry.kind === 'float16' ? 2 : 4;
    const length = width * entry.shape.reduce((a, b) => a * b, 1);
    found[name] = unpacked(entry, bytes.subarray(at, at + length));
    at += length;
  }
  return found;
}

/** Illuminance and reflected radiosity (lux, red, green, blue) of all vertices: sums of groups. */
function mixed(rows, weights) {
  const count = rows[0].length, found = new Float32Array(4 * count);
  weights.forEach((weight, group) => {
    if (weight === 0) return;
    for (let c = 0; c < 4; c++) {
      const row = rows[4 * group + c];
      for (let k = 0, at = c; k < count; k++, at += 4) found[at] += weight * row[k];
    }
  });
  return found;
}

/** What the front of a material emits, W/m2. */
function emitted(material, weights) {
  const own = material.emission;
  return own ? times(weights[own.group], own.rgb) : [0, 0, 0];
}
