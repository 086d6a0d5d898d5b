// Light and material: lights as dots on a ball, material, background, tint of gaps, detail.
import {h, s, update} from '../elements/dom.js';
import {plain} from '../link/lines.js';
import {gesture, show, touch} from '../panel/gesture.js';
import {say} from '../texts/say.js';
import {LIMITS} from '../link/vocabulary.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').LightState} LightState */

const BALL = 34;              // Radius, in the drawing's units.
const REACH = 17;             // Radius at which a pointer grabs a dot: 44 px for a finger.
const KEY_DEG = 5;
const NEW_LIGHT = '0 45 intensity=0.4';
const DEGREE = Math.PI / 180;
const DETAILS = {exact: say`all`, auto: say`fewer while moving`, 1: say`cells of 2 voxels`,
  2: say`cells of 4 voxels`, 3: say`cells of 8 voxels`};

const STEREO_MODES = {off: say`off`, anaglyph: say`red/cyan glasses`, sbs: say`side by side`,
  cross: say`crossed eyes`, rows: say`alternate rows`};

const STEREO_TITLE = say`Draws a picture for each eye. The command stereo sets the distance of the
  eyes. Alternate rows are for 3-D monitors: the left eye has rows 0, 2, 4 … of the picture.
  If near and far are exchanged, move the window by one row of the monitor.`;

/**
 * The position of a light's dot on the ball, right and down. Lights from behind lie outside.
 * @param {LightState} light
 */
function dotOf({azimuth_deg, elevation_deg}) {
  const azimuth = azimuth_deg * DEGREE, elevation = elevation_deg * DEGREE;
  const [x, y] = [Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)];
  return {x: x * BALL, y: -y * BALL, isBehind: Math.cos(azimuth) * Math.cos(elevation) < 0};
}

/**
 * The angles of a point on the front of the ball. Points outside are moved to the rim.
 * @param {number} right  1 at the rim.
 * @param {number} up
 */
export function lightAt(right, up) {
  const length = Math.max(1, Math.hypot(right, up));
  const x = right / length, y = up / length;
  const z = Math.sqrt(Math.max(0, 1 - x * x - y * y));
  return {azimuth_deg: Math.atan2(x, z) / DEGREE, elevation_deg: Math.asin(y) / DEGREE};
}

/** The ball and the intensity of the light that is chosen. */
class LightBall {
  /**
   * @param {HTMLElement} root
   * @param {App} app
   */
  constructor(root, app) {
    /** @private */
    this.app_ = app;
    /** @private Index of the light that is chosen. */
    this.chosen_ = 0;
    /** @private */
    this.dots_ = s('g');
    /** @private */
    this.svg_ = s('svg', {id: 'light-ball', viewBox: '-44 -44 88 88', role: 'group',
      'data-testid': 'light-ball',
      'aria-label': say`Directions of the lights, seen from the viewer`},
      s('circle', {r: BALL, class: 'ball'}), this.dots_);
    /** @private */
    this.intensity_ = h('input', {type: 'range', min: 0, max: 2, step: 0.02,
      'aria-label': say`Light intensity`, 'data-testid': 'light-intensity',
      ...gesture(app.connection, () => this.send_(this.lights_()[this.chosen_]))});
    /** @private */
    this.add_ = h('button', {class: 'quiet', 'data-testid': 'add-light',
      onclick: () => this.addLight_()}, say`+ Light`);
    /** @private */
    this.remove_ = h('button', {class: 'quiet', 'data-testid': 'remove-light',
      onclick: () => void app.connection.do(`light ${this.chosen_ + 1} off`)}, say`Remove`);
    /** @type {(name: string, text: string, help: string) => HTMLElement} */
    const arrange = (name, text, help) => h('button', {class: 'quiet', title: help,
      'data-testid': `lights-${name}`,
      onclick: () => void app.connection.do(`light ${name}`)}, text);
    root.append(h('div', {class: 'row'}, this.svg_,
      h('div', {class: 'grow'}, h('p', {class: 'muted'}, say`Drag a dot to move a light.`),
        h('label', {}, say`Intensity`, this.intensity_),
        h('div', {class: 'row'}, this.add_, this.remove_),
        h('div', {class: 'row'}, arrange('two-point', say`Key and fill`, say`Two lights in front, as
          at the start`), arrange('three-point', say`With rim`, say`A third light from behind shows
          the edges`)))));
    app.store.subscribe(['lights'], () => this.draw_());
  }

  /** @private */
  lights_() {
    return this.app_.store.state?.lights ?? [];
  }

  /** @private */
  addLight_() {
    const count = this.lights_().length;
    this.chosen_ = count;
    void this.app_.connection.do(`light ${count + 1} ${NEW_LIGHT}`);
  }

  /** @private */
  draw_() {
    const lights = this.lights_();
    this.chosen_ = Math.max(0, Math.min(this.chosen_, lights.length - 1));
    while (this.dots_.childElementCount > lights.length) {
      this.dots_.lastElementChild?.remove();
    }
    lights.forEach((light, index) => {
      const dot = this.dots_.children[index] ?? this.makeDot_(index);
      const {x, y, isBehind} = dotOf(light);
      update(dot.children[1], {r: 4 + 2.5 * Math.min(1, light.intensity)});
      update(dot, {transform: `translate(${x} ${y})`,
        class: `light${index === this.chosen_ ? ' chosen' : ''}${isBehind ? ' behind' : ''}`,
        'aria-valuenow': Math.round(light.azimuth_deg),
        'aria-valuetext': say`${Math.round(light.azimuth_deg)}° right,
          ${Math.round(light.elevation_deg)}° up`});
    });
    this.intensity_.disabled = lights.length === 0;
    this.remove_.disabled = lights.length === 0;
    this.add_.disabled = lights.length >= LIMITS.max_lights;
    show(this.intensity_, String(lights[this.chosen_]?.intensity ?? 0));
  }

  /**
   * @private
   * @param {number} index
   */
  makeDot_(index) {
    const dot = s('g', {role: 'slider', tabindex: 0, 'aria-label': say`Light ${index + 1}`,
      'aria-valuemin': -180, 'aria-valuemax': 180, 'data-testid': `light-${index + 1}`},
    s('circle', {class: 'reach', r: REACH}), s('circle', {class: 'dot'}));
    const choose = () => {
      this.chosen_ = index;
      this.draw_();
    };
    dot.addEventListener('focus', choose);
    dot.addEventListener('pointerdown', event => {
      dot.setPointerCapture(event.pointerId);
      this.app_.connection.mark();
      choose();
    });
    dot.addEventListener('pointermove', event => {
      if (dot.hasPointerCapture(event.pointerId)) {
        const box = this.svg_.getBoundingClientRect();
        const unit = box.width / 88 * BALL;
        this.send_(lightAt((event.clientX - box.left - box.width / 2) / unit,
          (box.top + box.height / 2 - event.clientY) / unit));
      }
    });
    dot.addEventListener('keydown', event => {
      const light = this.lights_()[index];
      const step = new Map([['ArrowLeft', [-1, 0]], ['ArrowRight', [1, 0]],
        ['ArrowUp', [0, 1]], ['ArrowDown', [0, -1]]]).get(event.key);
      if (step) {
        event.preventDefault();
        event.stopPropagation();
        this.send_({azimuth_deg: light.azimuth_deg + step[0] * KEY_DEG,
          elevation_deg: Math.max(-90, Math.min(90, light.elevation_deg + step[1] * KEY_DEG))});
      }
    });
    this.dots_.append(dot);
    return dot;
  }

  /**
   * @private
   * @param {{azimuth_deg: number, elevation_deg: number} | undefined} light
   */
  send_(light) {
    if (light && !this.app_.connection.watches) {
      void this.app_.connection.set({name: 'light',
        words: [this.chosen_ + 1, plain(light.azimuth_deg, 1), plain(light.elevation_deg, 1)],
        options: {intensity: this.intensity_.value}});
    }
  }
}

/**
 * @param {HTMLElement} root
 * @param {App} app
 */
export function createLook(root, app) {
  new LightBall(root, app);
  createMaterial(root, app);
  createWarpSwitch(root, app);
}

const LOOK_TITLE = say`Turns the picture by a few degrees with the pointer over it, or with a phone
  in the hand, by the depths of the picture. The view stays the same. Touch the picture to make
  the present orientation of the phone the middle. Not with transparent surfaces.`;

/**
 * The switch of the pictures between pictures, and the switch of looking around.
 * @param {HTMLElement} root
 * @param {App} app
 */
function createWarpSwitch(root, {connection, toasts, picture: {warp}}) {
  if (!warp) {
    return;
  }
  const {parallax} = warp;
  const look = h('input', {type: 'checkbox', 'data-testid': 'parallax-switch',
    onchange: async () => {
      const why = look.checked ? await parallax.start() : '';
      if (why !== '') {
        toasts.info(why);
      }
      if (!look.checked) {
        parallax.stop();
      }
    }});
  const lookLabel = h('label', {class: 'row'}, look,
    say`Look around by moving the pointer or the phone`);
  const box = h('input', {type: 'checkbox', 'data-testid': 'warp-switch',
    onchange: () => { warp.isOn = box.checked; }});
  const label = h('label', {class: 'row'}, box, say`Follow the pointer between pictures`);
  root.append(label, lookLabel);
  warp.onSwitched(() => {
    lookLabel.hidden = label.hidden = connection.watches;
    look.checked = parallax.isOn;
    look.disabled = !warp.isOn;
    lookLabel.title = warp.isOn ? LOOK_TITLE : say`Needs "Follow the pointer between pictures".`;
    box.checked = warp.isOn;
    box.disabled = warp.refusal !== '';
    label.title = box.disabled ? say`Not possible here: ${warp.refusal}.`
      : say`While the view moves, shows the newest picture from the newest viewpoint by its depths.
        Parts that the picture has not seen are hatched. Not with two or more transparent
        surfaces, nor with one in stereo.`;
  });
}

/**
 * @param {HTMLElement} root
 * @param {App} app
 */
function createMaterial(root, app) {
  const rows = /** @type {const} */ ([
    ['ambient', say`Ambient`, 0, 1, 0.01, say`Brightness without direct light`],
    ['specular', say`Gloss`, 0, 1, 0.01, say`Strength of the highlights`],
    ['power', say`Sharpness`, 1, LIMITS.max_specular_power, 1,
      say`Larger values give smaller highlights`],
  ]).map(([key, label, min, max, step, title]) => {
    const input = h('input', {type: 'range', min, max, step, 'data-testid': `material-${key}`,
      ...gesture(app.connection, () => void app.connection.set({name: 'material',
        options: {[key]: input.value}}))});
    root.append(h('label', {class: 'row', title}, h('span', {class: 'field'}, label), input));
    return {key, input};
  });
  const color = h('input', {type: 'color', 'data-testid': 'background',
    ...gesture(app.connection,
      () => void app.connection.set({name: 'background', words: [color.value]}))});
  const gaps = h('input', {type: 'checkbox', 'data-testid': 'tint-gaps',
    onchange: () => {
      touch(gaps);
      void app.connection.set({name: 'tint', words: [gaps.checked ? 'gaps' : 'off']});
    }});
  const gapLabel = h('label', {class: 'row'}, gaps, say`Tint where slices are missing`);
  const detail = h('select', {'data-testid': 'detail', onchange: async () => {
    detail.blur();
    await app.connection.do(`detail ${detail.value}`);
    show(detail, app.store.state?.detail ?? detail.value);  // Again the old one after an error.
  }}, ...Object.entries(DETAILS).map(([value, text]) => h('option', {value}, text)));
  const stereo = h('select', {'data-testid': 'stereo', onchange: async () => {
    stereo.blur();
    await app.connection.do(`stereo ${stereo.value}`);
    show(stereo, app.store.state?.stereo ?? stereo.value);
  }}, ...Object.entries(STEREO_MODES).map(([value, text]) => h('option', {value}, text)));
  root.append(h('label', {class: 'row'}, h('span', {class: 'field'}, say`Background`), color),
    h('label', {class: 'row', title: say`Fewer triangles are drawn faster. The status line states
      how far surfaces are off. "Fewer while moving": above 2 million triangles; exact at rest`},
    h('span', {class: 'field'}, say`Triangles`), detail),
    h('label', {class: 'row', title: STEREO_TITLE},
      h('span', {class: 'field'}, say`Stereo`), stereo),
    gapLabel);
  app.store.subscribe(['material', 'background', 'tint_gaps', 'volume'], state => {
    for (const {key, input} of rows) {
      show(input, String(state.material[key]));
    }
    show(color, state.background);
    show(gaps, state.tint_gaps);
    gapLabel.hidden = (state.volume?.gaps ?? 0) === 0;
  });
  app.store.subscribe(['detail', 'stereo'], state => {
    show(detail, state.detail);
    show(stereo, state.stereo);
  });
}
