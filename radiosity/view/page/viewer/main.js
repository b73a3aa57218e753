// Puts the parts together.

const STOPS = 6;

function fail(text) {
  byId('message').textContent = text;
  byId('message').hidden = false;
  document.documentElement.dataset.failed = '';
}

function bounds(points) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < points.length; k++) {
    low[k % 3] = Math.min(low[k % 3], points[k]);
    high[k % 3] = Math.max(high[k % 3], points[k]);
  }
  return [times(0.5, add(low, high)), 0.5 * Math.hypot(...subtract(high, low)) || 1];
}

class Page {
  constructor(about, arrays) {
    Object.assign(this, { about, arrays, picked: null, waiting: false });
    this.state = { stops: 0, lux: false, log: false, lines: true, top: about.most, levels: [],
      weights: about.groups.map(() => 1) };
    this.canvas = byId('view');
    this.eye = new Eye(about.up, ...bounds(arrays.points));
    this.drawing = new Drawing(this.canvas, about, arrays, () => this.ask());
    this.views = [...about.cameras, this.eye.overview()];
    tellAbout(about);
    makeLamps(about, arrays, this.state, () => this.relight());
    this.connect();
    this.eye.follow(this.views[0]);
    this.rescale();
    this.relight();
    tellPoint(about, null);
  }

  /** Draw when the browser is ready to. */
  ask() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    this.drawing.draw(this.eye, this.state);
    this.mark();
  }

  /** Put the ring where the picked point is, dashed and dim where something hides the point. */
  mark() {
    const marker = byId('marker');
    marker.hidden = this.picked === null;
    if (this.picked === null) return;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [x, y, , w] = projected(this.eye.matrix(width / height), this.picked.point);
    marker.hidden = w <= 0;
    marker.classList.toggle('behind', hidden(this.about, this.arrays, this.eye.position, this.picked));
    marker.style.transform = `translate(${(x / w + 1) * width / 2}px, ${(1 - y / w) * height / 2}px)`;
  }

  relight() {
    this.light = mixed(this.arrays.light, this.state.weights);
    this.drawing.light(this.light);
    this.tell();
    this.ask();
  }

  tell() {
    const { about, arrays, light, state, picked } = this;
    const found = picked && known(about, arrays, light, state.weights, picked);
    tellPoint(about, found);
    if (found) byId('marker').querySelector('span').textContent = `${told(found.lux)} lx`;
  }

  pick(x, y) {
    const box = this.canvas.getBoundingClientRect(), aspect = box.width / box.height;
    const across = 2 * (x - box.left) / box.width - 1, above = 1 - 2 * (y - box.top) / box.height;
    const direction = this.eye.ray(across, above, aspect);
    this.picked = hit(this.arrays.points, this.arrays.triangles, this.about.parts, this.eye.position, direction);
    this.tell();
    this.ask();
  }

  forget() {
    this.picked = null;
    this.tell();
    this.ask();
  }

  rescale() {
    this.state.levels = levelsOf(this.state.top, this.state.log);
    byId('top').value = tidy(this.state.top);
    byId('log').checked = this.state.log;
    byId('lines').checked = this.state.lines;
    drawScale(this.about, this.state);
    this.ask();
  }

  expose(stops) {
    this.state.stops = clamp(Math.round(10 * stops) / 10, -STOPS, STOPS);
    byId('stops').value = this.state.stops;
    byId('stops-told').textContent = `${this.state.stops > 0 ? '+' : ''}${this.state.stops}`;
    this.ask();
  }

  show(lux) {
    this.state.lux = lux;
    press('lux', lux);
    press('picture', !lux);
    byId('lux-rows').hidden = byId('scale').hidden = !lux;
    byId('stops-row').hidden = lux;
    this.ask();
  }

  walk(on) {
    this.eye.walking = on;
    press('walk', on);
    press('orbit', !on);
  }

  fold(folded) {
    document.body.classList.toggle('folded', folded);
    byId('open').setAttribute('aria-expanded', String(!folded));
    this.ask();
  }

  /** Go to a view, gliding there unless less motion is asked for. */
  go(number) {
    const view = this.views[number];
    if (!view) return;
    const before = { ...this.eye }, begun = performance.now(), target = Object.create(this.eye);
    target.follow(view);
    const after = { ...target };
    const calm = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
    const step = (now) => {
      const t = calm ? 1 : clamp((now - begun) / 450, 0, 1), s = t * t * (3 - 2 * t);
      if (this.going !== begun) return;
      this.between(before, after, s);
      if (t < 1) requestAnimationFrame(step);
    };
    this.going = begun;
    step(begun);
  }

  between(before, after, share) {
    const eye = this.eye, mix = (a, b) => (share === 1 ? b : a + share * (b - a));
    const blend = (a, b) => a.map((x, k) => mix(x, b[k]));
    eye.position = blend(before.position, after.position);
    for (const name of ['fov', 'distance', 'aspect']) eye[name] = mix(before[name], after[name]);
    if (share === 1) {
      Object.assign(eye, { forward: after.forward, right: after.right, up: after.up });
    } else {
      const forward = blend(before.forward, after.forward), up = blend(before.up, after.up);
      const right = cross(forward, up);
      if (Math.hypot(...right) < 1e-3 || Math.hypot(...forward) < 1e-3) return;
      eye.forward = unit(forward);
      eye.right = unit(right);
      eye.up = cross(eye.right, eye.forward);
    }
    this.ask();
  }

  save() {
    this.draw();
    this.canvas.toBlob((blob) => {
      const link = element('a', '', { href: URL.createObjectURL(blob), download: 'radiosity.png' });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  connect() {
    const click = (id, work) => byId(id).addEventListener('click', work);
    connect(this.canvas, this.eye, () => this.moved(), (x, y) => this.pick(x, y));
    byId('views').replaceChildren(...this.views.map((view, k) => {
      const button = element('button', view.name, { title: k < 9 ? `${view.name} (${k + 1})` : view.name });
      button.addEventListener('click', () => this.go(k));
      return button;
    }));
    click('orbit', () => this.walk(false));
    click('walk', () => this.walk(true));
    click('picture', () => this.show(false));
    click('lux', () => this.show(true));
    click('save', () => this.save());
    click('open', () => this.fold(!document.body.classList.contains('folded')));
    byId('stops').addEventListener('input', (event) => this.expose(Number(event.target.value)));
    byId('stops').addEventListener('dblclick', () => this.expose(0));
    byId('log').addEventListener('change', () => this.set('log', byId('log').checked));
    byId('lines').addEventListener('change', () => this.set('lines', byId('lines').checked));
    byId('top').addEventListener('change', (event) => {
      const top = Number(event.target.value);
      this.set('top', top > 0 && Number.isFinite(top) ? top : this.state.top);
    });
    window.addEventListener('keydown', (event) => this.key(event));
    window.addEventListener('resize', () => this.ask());
    this.canvas.addEventListener('webglcontextlost', () => fail('The graphics card has gone: load the page again.'));
  }

  moved() {
    this.going = null;
    this.ask();
  }

  set(name, value) {
    this.state[name] = value;
    this.rescale();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.type === 'number') return;
    const { state } = this;
    const work = {
      f: () => this.show(!state.lux), i: () => this.set('lines', !state.lines),
      l: () => this.set('log', !state.log), o: () => this.walk(!this.eye.walking),
      p: () => this.fold(!document.body.classList.contains('folded')),
      '[': () => this.expose(state.stops - 0.5), ']': () => this.expose(state.stops + 0.5),
      0: () => this.expose(0), Escape: () => this.forget(),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (work) work();
    else if (/^[1-9]$/.test(event.key)) this.go(Number(event.key) - 1);
  }
}

/** What the browser lacks. */
class Missing extends Error {}

async function start() {
  const about = JSON.parse(byId('about').textContent);
  if (!window.DecompressionStream) {
    throw new Missing('This browser is too old for the page: it knows no DecompressionStream (2023). A newer one shows the scene.');
  }
  if (!document.createElement('canvas').getContext('webgl2')) {
    throw new Missing('This browser shows no WebGL 2, which the scene is drawn with: switch hardware acceleration on, or take another browser.');
  }
  const arrays = await readArrays(byId('light').textContent.trim(), about.arrays);
  byId('light').remove();
  const page = new Page(about, arrays);
  requestAnimationFrame(() => {
    page.draw();
    page.drawing.gl.finish();
    performance.mark('drawn');
    byId('message').hidden = true;
    document.documentElement.dataset.ready = '';
  });
}

start().catch((error) => {
  fail(error.message);
  if (!(error instanceof Missing)) throw error;
});
