// WebGL 2: one mesh, drawn material by material, its light interpolated between vertices.

const VERTEX = `#version 300 es
in vec3 point; in vec4 light; in vec2 place;
uniform mat4 matrix;
out vec4 seen; out vec2 at;
void main() { seen = light; at = place; gl_Position = matrix * vec4(point, 1.0); }`;

const LINES = 40;
const FRAGMENT = `#version 300 es
precision highp float;
in vec4 seen; in vec2 at;
uniform sampler2D picture, colours;
uniform bool textured, falseColours;
uniform float white, exposure, opacity, top, decades, levels[${LINES}];
uniform int count;
uniform vec3 emission;
out vec4 shown;

const vec3 WEIGHTS = vec3(0.2126, 0.7152, 0.0722);
const float SEEN = 0.5 / 255.0 / 12.92;

vec3 inGamut(vec3 c) {  // as radiosity.light.colour.in_gamut
  float low = min(c.r, min(c.g, c.b)), y = max(dot(c, WEIGHTS), 0.0);
  return low >= -SEEN ? c : max(y + y / (y - low) * (c - y), 0.0);
}

vec3 encoded(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

vec3 falseColour(float lux, float slope) {
  float share = max(lux / top, 0.0);
  if (decades > 0.0) share = 1.0 + log(max(share, 1e-30)) / 2.302585093 / decades;
  vec3 colour = texture(colours, vec2(clamp(share, 0.001, 0.999), 0.5)).rgb;
  float line = 0.0;
  for (int k = 0; k < count; k++) {
    float off = abs(lux - levels[k]) / max(slope, 1e-4 * levels[k]);
    line = max(line, 1.0 - smoothstep(0.4, 1.3, off));
  }
  if (slope < 1e-4 * abs(lux)) line = 0.0;  // as good as even: no line through all of it
  return mix(colour, vec3(share < 0.6 ? 1.0 : 0.0), 0.8 * line);
}

void main() {
  float slope = fwidth(seen.x);
  if (falseColours) {
    shown = vec4(falseColour(seen.x, slope), opacity);
    return;
  }
  vec3 reflected = seen.yzw;
  if (textured) reflected *= white * texture(picture, at).rgb;
  shown = vec4(encoded(inGamut((emission + reflected) * exposure)), opacity);
}`;

function compiled(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const told = gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`The graphics driver refuses to draw: ${told.join(' ')}`);
  }
  return program;
}

/** A texture of one colour, until its picture is there. */
function textureOf(gl, repeat, changed, url) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4).fill(128));
  const image = new Image();
  image.addEventListener('load', () => {
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    const wrap = repeat ? gl.REPEAT : gl.CLAMP_TO_EDGE;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, wrap);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, wrap);
    changed();
  });
  image.src = url;
  return texture;
}

function mapOf(gl, colours) {
  const texture = gl.createTexture(), bytes = new Uint8Array(colours.flatMap((c) => [...c, 255]));
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, colours.length, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  for (const name of ['MIN_FILTER', 'MAG_FILTER']) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.NEAREST);
  return texture;
}

class Drawing {
  constructor(canvas, about, arrays, changed) {
    const gl = canvas.getContext('webgl2', { antialias: true, alpha: false });
    Object.assign(this, { canvas, about, gl, program: compiled(gl) });
    gl.bindVertexArray(gl.createVertexArray());
    this.fill('point', 3, arrays.points);
    this.lightBuffer = this.fill('light', 4, null);
    if (arrays.uv) this.fill('place', 2, arrays.uv);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, arrays.triangles, gl.STATIC_DRAW);
    this.map = mapOf(gl, about.map);
    this.textures = about.materials.map(
      (m) => (m.picture ? textureOf(gl, m.picture.repeat, changed, m.picture.url) : null));
    const clear = (part) => about.materials[part.material].opacity < 1;
    this.order = [...about.parts.filter((p) => !clear(p)), ...about.parts.filter(clear)];
    this.places = {};
  }

  fill(name, width, values) {
    const gl = this.gl, buffer = gl.createBuffer(), place = gl.getAttribLocation(this.program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    if (values) gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, width, gl.FLOAT, false, 0, 0);
    return buffer;
  }

  /** Take the light of all vertices, see `mixed`. */
  light(values) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lightBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
  }

  place(name) {
    this.places[name] ??= this.gl.getUniformLocation(this.program, name);
    return this.places[name];
  }

  draw(eye, state) {
    const { gl, canvas } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(0.07, 0.078, 0.09, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.polygonOffset(2, 4);
    gl.useProgram(this.program);
    this.tell(eye.matrix(width / height), state);
    for (const part of this.order) this.drawPart(part, state.weights);
  }

  tell(matrix, state) {
    const gl = this.gl, lines = state.lines ? state.levels.slice(0, LINES) : [];
    gl.uniformMatrix4fv(this.place('matrix'), false, matrix);
    gl.uniform1i(this.place('falseColours'), state.lux ? 1 : 0);
    gl.uniform1f(this.place('exposure'), this.about.exposure * 2 ** state.stops / Math.PI);
    gl.uniform1f(this.place('top'), state.top);
    gl.uniform1f(this.place('decades'), state.log ? DECADES : 0);
    gl.uniform1i(this.place('count'), lines.length);
    if (lines.length) gl.uniform1fv(this.place('levels'), lines);
    gl.uniform1i(this.place('picture'), 0);
    gl.uniform1i(this.place('colours'), 1);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.map);
    gl.activeTexture(gl.TEXTURE0);
  }

  drawPart(part, weights) {
    const gl = this.gl, material = this.about.materials[part.material];
    const texture = this.textures[part.material], clear = material.opacity < 1;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(this.place('textured'), texture ? 1 : 0);
    gl.uniform1f(this.place('white'), texture ? material.picture.white : 1);
    gl.uniform1f(this.place('opacity'), material.opacity);
    gl.uniform3fv(this.place('emission'), part.back ? [0, 0, 0] : emitted(material, weights));
    gl.depthMask(!clear);
    // A floor goes on, black, under a block: pushed back, so that it does not flicker at the seam.
    if (part.dark) gl.enable(gl.POLYGON_OFFSET_FILL); else gl.disable(gl.POLYGON_OFFSET_FILL);
    if (clear) gl.enable(gl.BLEND); else gl.disable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 4 * part.start);
  }
}
