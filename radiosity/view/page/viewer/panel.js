// The panel beside the picture: what can be set, and what is told.

const DECADES = 3; // of a logarithmic scale, as in our pictures
const byId = (id) => document.getElementById(id);

function element(kind, text, more = {}) {
  const made = document.createElement(kind);
  made.textContent = text;
  for (const [name, value] of Object.entries(more)) made.setAttribute(name, value);
  return made;
}

/** A number with three digits at least. */
function told(x) {
  if (x === 0) return '0';
  const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.abs(x))));
  return digits > 8 ? x.toPrecision(3) : x.toFixed(Math.min(digits, 8));
}

/** Where an illuminance is on a scale, from 0 to 1. */
const placeOn = (top, log, lux) => (log ? 1 + Math.log10(lux / top) / DECADES : lux / top);

/** Round illuminances on a scale up to `top`, ascending, with room for their numbers. */
function levelsOf(top, log) {
  const fits = (lux) => Math.abs(placeOn(top, log, lux) - 0.5) < 0.46;
  const found = [];
  if (log) {
    const low = Math.floor(Math.log10(top) - DECADES);
    for (let power = low; power <= Math.log10(top); power++) {
      for (const m of [1, 2, 5]) found.push(m * 10 ** power);
    }
    return found.filter(fits);
  }
  const unitStep = 10 ** Math.floor(Math.log10(top / 5));
  const step = [1, 2, 5, 10].map((m) => m * unitStep).find((s) => top / s <= 10);
  for (let k = 1; k * step < top; k++) found.push(k * step);
  return found.filter(fits);
}

function drawScale(about, state) {
  const context = byId('scale').querySelector('canvas').getContext('2d');
  about.map.forEach((colour, k) => {
    context.fillStyle = `rgb(${colour.join(',')})`;
    context.fillRect(0, 255 - k, 1, 1);
  });
  const ends = [[0, state.log ? `≤ ${tidy(state.top * 10 ** -DECADES)}` : '0'], [1, `≥ ${tidy(state.top)}`]];
  const inner = state.levels.map((x) => [placeOn(state.top, state.log, x), tidy(x)]);
  byId('ticks').replaceChildren(...[...ends, ...inner].map(([p, text]) => {
    const tick = element('span', text);
    tick.style.bottom = `${100 * p}%`;
    return tick;
  }));
}

const tidy = (x) => String(Number(x.toPrecision(4)));

/** A slider for each group that has light; its name switches the group off and on. */
function makeLamps(about, arrays, state, changed) {
  const shines = (k) => arrays.light[4 * k].some((x) => x > 0)
    || about.materials.some((m) => m.emission && m.emission.group === k);
  const lit = [...about.groups.keys()].filter(shines);
  byId('lamps-section').hidden = lit.length === 0;
  byId('lamps').replaceChildren(...lit.map((k) => {
    const name = about.groups[k];
    const row = element('div', '', { class: 'slider' });
    const button = element('button', name, { title: `${name}: off, on`, 'aria-pressed': 'true' });
    const slider = element('input', '', { type: 'range', min: 0, max: 200, value: 100, 'aria-label': name });
    const percent = element('output', '100 %');
    const set = (value) => {
      slider.value = value;
      percent.textContent = `${value} %`;
      button.setAttribute('aria-pressed', String(value > 0));
      state.weights[k] = value / 100;
      changed();
    };
    let before = 100;
    slider.addEventListener('input', () => set(Number(slider.value)));
    slider.addEventListener('dblclick', () => set(100));
    button.addEventListener('click', () => {
      const value = Number(slider.value);
      if (value > 0) before = value;
      set(value > 0 ? 0 : before);
    });
    row.append(button, slider, percent);
    return row;
  }));
}

function list(id, rows) {
  byId(id).replaceChildren(...rows.flatMap(([name, value]) => [element('dt', name), element('dd', value)]));
}

/** Tell what is known of a point, with all digits in the data of the list. */
function tellPoint(about, found) {
  byId('no-point').hidden = found !== null;
  const place = byId('point');
  for (const name of Object.keys(place.dataset)) delete place.dataset[name];
  if (!found) {
    list('point', []);
    return;
  }
  const nearly = found.textured ? '≈ ' : ''; // of the texture's mean
  const far = Math.max(...found.point.map(Math.abs));
  const where = found.point.map((x) => told(Math.abs(x) < 1e-6 * far ? 0 : x)); // single precision
  const unknown = found.estimated ? 'known when sliders agree' : 'not estimated';
  const error = found.error === null ? unknown : `± ${told(found.error)} lx`;
  list('point', [
    ['illuminance', `${told(found.lux)} lx`],
    ['estimated error', error],
    ['luminance', `${nearly}${told(found.luminance)} cd/m²`],
    ['material', found.side === 'back' ? `${found.material.name} (back)` : found.material.name],
    ['reflectance', `${nearly}${(100 * found.reflectance).toFixed(0)} %`],
    ['position', `${where.join(', ')} ${about.unit}`],
  ]);
  Object.assign(place.dataset, { lux: found.lux, luminance: found.luminance, material: found.material.name,
    error: found.error ?? '' });
  found.point.forEach((x, k) => { place.dataset['xyz'[k]] = x; });
  found.normal.forEach((x, k) => { place.dataset[['nx', 'ny', 'nz'][k]] = x; });
}

function tellAbout(about) {
  document.querySelector('#name').textContent = about.name;
  list('facts', about.facts);
  byId('missing').textContent = about.missing;
}

const press = (id, on) => byId(id).setAttribute('aria-pressed', String(on));
