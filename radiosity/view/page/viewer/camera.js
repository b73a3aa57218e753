// Where one looks from. Exactly as a camera of the scene until it is turned; then upright.

const FLAT = 2; // degrees that stand for an orthographic camera's 0
const STEEPEST = radians(89.5);

class Eye {
  constructor(up, centre, radius) {
    Object.assign(this, { centre, radius, worldUp: unit(up) });
    const aside = Math.abs(this.worldUp[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    this.east = unit(cross(aside, this.worldUp));
    this.north = cross(this.worldUp, this.east);
    this.walking = false;
  }

  /** Look as a camera of the scene does. */
  follow(camera) {
    const { position, forward, right, up, aspect } = camera;
    Object.assign(this, { position, forward, right, up, aspect, fov: camera.fov });
    const ahead = dot(subtract(this.centre, position), forward);
    this.distance = ahead > 0.05 * this.radius ? ahead : 0.5 * this.radius;
    if (camera.height !== null) {
      const pivot = add(position, times(this.distance, forward));
      this.fov = FLAT;
      this.distance = camera.height / (2 * Math.tan(radians(FLAT) / 2));
      this.position = subtract(pivot, times(this.distance, forward));
    }
  }

  /** The whole scene, from above at an angle. */
  overview() {
    this.aim(radians(-60), radians(-25));
    const distance = 1.05 * this.radius / Math.sin(radians(40) / 2);
    return { name: 'Overview', position: subtract(this.centre, times(distance, this.forward)),
      forward: this.forward, right: this.right, up: this.up, fov: 40, height: null, aspect: 1 };
  }

  aim(yaw, pitch) {
    const level = add(times(Math.cos(yaw), this.east), times(Math.sin(yaw), this.north));
    this.forward = add(times(Math.cos(pitch), level), times(Math.sin(pitch), this.worldUp));
    this.right = cross(level, this.worldUp);
    this.up = cross(this.right, this.forward);
  }

  turn(across, down) {
    const rise = dot(this.forward, this.worldUp);
    const steep = Math.abs(rise) > Math.sin(STEEPEST);
    const ahead = steep ? times(-Math.sign(rise), this.up) : this.forward;
    const yaw = Math.atan2(dot(ahead, this.north), dot(ahead, this.east)) - across;
    const pivot = add(this.position, times(this.distance, this.forward));
    this.aim(yaw, clamp(Math.asin(clamp(rise, -1, 1)) - down, -STEEPEST, STEEPEST));
    if (!this.walking) this.position = subtract(pivot, times(this.distance, this.forward));
  }

  shift(across, up) {
    const by = add(times(across, this.right), times(up, this.up));
    this.position = add(this.position, by);
  }

  nearer(factor) {
    if (this.walking) {
      this.walk(0, -Math.log(factor) * 0.5 * this.radius, 0);
      return;
    }
    const pivot = add(this.position, times(this.distance, this.forward));
    this.distance = clamp(this.distance * factor, 1e-3 * this.radius, 1e3 * this.radius);
    this.position = subtract(pivot, times(this.distance, this.forward));
  }

  /** Move by lengths along the ground, and up. */
  walk(right, ahead, up) {
    let level = subtract(this.forward, times(dot(this.forward, this.worldUp), this.worldUp));
    if (Math.hypot(...level) < 1e-3) level = this.up;
    const by = add(times(right, this.right), add(times(ahead, unit(level)), times(up, this.worldUp)));
    this.position = add(this.position, by);
  }

  /** Half the height of what is seen at distance 1: sides that the scene's camera sees stay. */
  tangent(aspect) {
    return Math.tan(radians(this.fov) / 2) * Math.max(1, this.aspect / aspect);
  }

  matrix(aspect) {
    const away = Math.hypot(...subtract(this.centre, this.position)), reach = 1.01 * this.radius;
    const near = Math.max(away - reach, 4e-3 * this.radius), far = Math.max(away + reach, 2 * near);
    const axes = [this.right, this.up, this.forward];
    return toScreen(this.position, ...axes, this.tangent(aspect), aspect, near, far);
  }

  /** The direction through a point of the screen, from (-1, -1) to (1, 1). */
  ray(x, y, aspect) {
    const t = this.tangent(aspect);
    const aside = add(times(x * t * aspect, this.right), times(y * t, this.up));
    return unit(add(this.forward, aside));
  }
}

const WALKS = {
  KeyW: [0, 1, 0], ArrowUp: [0, 1, 0], KeyS: [0, -1, 0], ArrowDown: [0, -1, 0],
  KeyA: [-1, 0, 0], ArrowLeft: [-1, 0, 0], KeyD: [1, 0, 0], ArrowRight: [1, 0, 0],
  KeyE: [0, 0, 1], KeyQ: [0, 0, -1],
};

/** Let mouse, fingers and keys move an eye; a click that drags nothing calls `clicked`. */
function connect(canvas, eye, changed, clicked) {
  const down = new Map();
  let moved = 0, most = 0;
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    if (down.size === 0) moved = most = 0;
    down.set(event.pointerId, [event.clientX, event.clientY]);
    most = Math.max(most, down.size);
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], by = [now[0] - before[0], now[1] - before[1]];
    const others = [...down].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    down.set(event.pointerId, now);
    moved += Math.hypot(...by);
    const height = canvas.clientHeight, aspect = canvas.clientWidth / height;
    const pixel = 2 * eye.tangent(aspect) * eye.distance / height;
    if (others.length) {
      const span = (at) => Math.hypot(at[0] - others[0][0], at[1] - others[0][1]);
      eye.nearer(Math.max(span(before), 1) / Math.max(span(now), 1));
      eye.shift(-by[0] * pixel / 2, by[1] * pixel / 2);
    } else if (event.buttons === 1 && !event.shiftKey) {
      const angle = (eye.walking ? -2 * eye.tangent(aspect) : Math.PI) / height;
      eye.turn(by[0] * angle, by[1] * angle);
    } else {
      eye.shift(-by[0] * pixel, by[1] * pixel);
    }
    changed();
  });
  const up = (event) => {
    if (!down.delete(event.pointerId) || event.type !== 'pointerup') return;
    if (moved < 4 && most === 1 && event.button === 0) clicked(event.clientX, event.clientY);
  };
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    eye.nearer(Math.exp(clamp(event.deltaY * (event.deltaMode ? 30 : 1), -200, 200) * 1.5e-3));
    changed();
  }, { passive: false });
  connectWalking(eye, changed);
}

function connectWalking(eye, changed) {
  const held = new Set();
  let last = 0;
  const step = (now) => {
    if (!held.size) return;
    const by = [...held].reduce((sum, code) => add(sum, WALKS[code]), [0, 0, 0]);
    const length = 0.45 * eye.radius * Math.min((now - last) / 1000, 0.1);
    last = now;
    eye.walk(...times(length, by));
    changed();
    requestAnimationFrame(step);
  };
  window.addEventListener('keydown', (event) => {
    if (!(event.code in WALKS) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLInputElement) return;
    event.preventDefault();
    const first = held.size === 0;
    held.add(event.code);
    if (first) {
      last = performance.now();
      requestAnimationFrame(step);
    }
  });
  window.addEventListener('keyup', (event) => held.delete(event.code));
  window.addEventListener('blur', () => held.clear());
}
