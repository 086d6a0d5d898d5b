// Over the picture: letters of the patient's sides, scale bar, cube and crosshair.
import {remPx} from '../elements/canvas.js';
import {byId, h, s, setText, update} from '../elements/dom.js';
import {placeWarning} from '../panel/volume_words.js';
import {lettersTowards, roundLength, SIDES, toEye} from '../picture/projection.js';
import {say} from '../texts/say.js';
import {moveToMenu} from './view_tools.js';

/** @typedef {import('../link/types.js').Triple} Triple */

const MARGIN_REM = 1.2;     // From the edge of the picture to a letter.
const BAR_SHARE = 0.25;     // Maximum length, as a share of the picture's width.
const CROSS_PX = 9;
const CUBE_HALF = 21;
const CUT = say`The picture is larger than its panel. A picture of alternate rows is never scaled,
  so its edges are hidden. Choose a smaller size, or "fit to panel", below.`;
/** @type {Record<string, string>}  What chooses a named view. */
const SHOW = {
  anterior: say`Show the anterior view`,
  posterior: say`Show the posterior view`,
  left: say`Show the left view`,
  right: say`Show the right view`,
  superior: say`Show the superior view`,
  inferior: say`Show the inferior view`,
};
const EDGES = /** @type {{at: [number, number], anchor: string, on: [number, number]}[]} */ ([
  {at: [0, 0.5], anchor: 'start', on: [-1, 0]},
  {at: [1, 0.5], anchor: 'end', on: [1, 0]},
  {at: [0.5, 0], anchor: 'middle', on: [0, 1]},
  {at: [0.5, 1], anchor: 'middle', on: [0, -1]},
]);

/**
 * @param {import('../panel/app.js').App} app
 * @param {import('../picture/viewpoint.js').Viewpoint} viewpoint
 */
export function createOverlay(app, viewpoint) {
  const {picture} = app, cut = byId('cut');
  // The second of each is for the right part of a picture of both eyes.
  const frames = ['scale-bar', 'scale-bar-2'].map(id => new Frame(id));
  const crosses = ['crosshair', 'crosshair-2'].map(id => s('g', {visibility: 'hidden',
    'data-testid': id},
  s('path', {d: `M${-CROSS_PX} 0H-3M3 0H${CROSS_PX}M0 ${-CROSS_PX}V-3M0 3V${CROSS_PX}`})));
  picture.overlay.append(...frames.map(({root}) => root), ...crosses);
  const cube = createCube(app, viewpoint);
  /** @type {Triple | null} */
  let place = null;

  const redraw = () => {
    const {camera, height} = picture, eyes = picture.eyes();
    // Before anything changes: a change makes the browser compute all styles again.
    const margin = MARGIN_REM * remPx();
    update(picture.overlay, {visibility: camera ? null : 'hidden'});
    setText(cut, CUT);
    cut.hidden = !camera || !picture.isCut;
    // Of an anaglyph both eyes see one frame, at the depth of the screen.
    const parts = eyes.filter(({left}, index) => index === 0 || left > 0);
    frames.forEach(({root}, index) =>
      update(root, {visibility: index < parts.length ? null : 'hidden'}));
    parts.forEach(({left, width}, index) => camera && frames[index].draw(camera.patient_to_eye,
      {left, width, height, mmPerPlace: viewpoint.mmPerPlace(), margin}));
    crosses.forEach((cross, index) => {
      const eye = eyes[index], at = place && eye?.project(place);
      update(cross, at?.visible ? {transform: `translate(${at.x} ${at.y})`, visibility: 'visible'}
        : {visibility: 'hidden'});
      update(cross, {class: `crosshair eye-${eye?.name ?? 'middle'}`});
    });
    if (camera) {
      cube(camera.patient_to_eye);
    }
  };
  picture.onChange(redraw);
  document.addEventListener('place', event => {
    place = /** @type {CustomEvent} */ (event).detail.p_mm;
    redraw();
  });
  app.store.subscribe(['background'], ({background}) => {
    picture.overlay.classList.toggle('on-light', isLight(background));
    picture.stage.style.backgroundColor = background;  // The ground of the picture, in any theme.
  });
  app.store.subscribe(['stereo'], ({stereo}) => {
    picture.overlay.classList.toggle('anaglyph', stereo === 'anaglyph');
  });
  app.store.subscribe(['volume'], ({volume}) => {
    place = null;
    redraw();
    showWarning(placeWarning(volume));
  });
}

/** Letters and scale bar at the edges of a part of the picture. */
class Frame {
  /** @param {string} id  For the tests. */
  constructor(id) {
    /** @private */
    this.letters_ = EDGES.map(({anchor}) => s('text', {class: 'side', 'text-anchor': anchor}));
    // A dark line behind the light line, so that the bar is visible on any ground.
    /** @private */
    this.bar_ = s('g', {'data-testid': id}, s('path', {class: 'scale-edge'}),
      s('path', {class: 'scale'}));
    /** @private */
    this.barText_ = s('text', {class: 'scale-text'});
    this.root = s('g', {}, s('g', {}, ...this.letters_), s('g', {}, this.bar_, this.barText_));
  }

  /**
   * @param {number[]} patientToEye
   * @param {{left: number, width: number, height: number, mmPerPlace: number, margin: number}} part
   *   In places.
   */
  draw(patientToEye, {left, width, height, mmPerPlace, margin}) {
    EDGES.forEach(({at, on}, index) => {
      setText(this.letters_[index], lettersTowards(patientToEye, on));
      update(this.letters_[index], {x: left + margin + at[0] * (width - 2 * margin),
        y: margin + at[1] * (height - 2 * margin), dy: '0.36em'});
    });
    drawBar(this.bar_, this.barText_, mmPerPlace,
      {x: left + margin, y: height - margin, width});
  }
}

/** @param {string} text */
function showWarning(text) {
  const warning = byId('assumed');
  warning.textContent = text;
  warning.hidden = text === '';
  byId('middle').classList.toggle('assumes', text !== '');
}

/**
 * Whether dark letters are easier to read on a color.
 * @param {string} color  #rrggbb
 */
function isLight(color) {
  const [red, green, blue] = [1, 3, 5].map(at => parseInt(color.slice(at, at + 2), 16) / 255);
  return 0.2126 * red ** 2.2 + 0.7152 * green ** 2.2 + 0.0722 * blue ** 2.2 > 0.4;
}

/**
 * @param {SVGGElement} bar  Its paths have the same shape.
 * @param {SVGTextElement} text
 * @param {number} mmPerPlace
 * @param {{x: number, y: number, width: number}} at  Its left end; the picture's width.
 */
function drawBar(bar, text, mmPerPlace, {x, y, width}) {
  const draw = (/** @type {string} */ d) => {
    for (const path of bar.children) {
      update(path, {d});
    }
  };
  if (mmPerPlace <= 0 || width === 0) {
    draw('M0 0');
    setText(text, '');
    return;
  }
  const mm = roundLength(width * BAR_SHARE * mmPerPlace);
  const px = mm / mmPerPlace;
  draw(`M${x} ${y - 4}v8M${x} ${y}h${px}m0 -4v8`);
  update(text, {x: x + 6, y: y - 6});
  setText(text, mm >= 10 ? `${mm / 10} cm` : `${mm} mm`);
}

/**
 * The cube that rotates with the patient. A click on a face chooses a named view.
 * @param {import('../panel/app.js').App} app
 * @param {import('../picture/viewpoint.js').Viewpoint} viewpoint
 * @returns {(patientToEye: number[]) => void} redraws the cube
 */
function createCube(app, viewpoint) {
  const faces = SIDES.map(({letter, view, towards}) => {
    const shape = s('polygon'), text = s('text', {'text-anchor': 'middle', dy: '0.36em'}, letter);
    const group = s('g', {class: 'face', role: 'button', 'aria-label': SHOW[view],
      'data-testid': `cube-${letter}`, onclick: () => viewpoint.named(view)},
      shape, text, s('title', {}, SHOW[view]));
    return {group, shape, text, towards};
  });
  const drawing = s('svg', {id: 'cube', viewBox: '-40 -40 80 80', role: 'group',
    'aria-label': say`Orientation`}, ...faces.map(({group}) => group));
  const buttons = SIDES.map(({letter, view}, index) => h('button', {class: 'quiet',
    title: say`${SHOW[view]} (key ${index + 1})`, 'aria-label': SHOW[view],
    'data-testid': `view-${view}`, onclick: () => viewpoint.named(view)}, letter));
  const views = h('div', {id: 'views', class: 'drives'}, ...buttons);
  byId('corner').append(drawing);
  moveToMenu('narrow', say`View`, views, () => byId('corner').append(views));
  app.store.subscribe(['volume', 'archive'], state => {
    views.hidden = byId('corner').hidden = !state.volume && !state.archive;
  });

  return patientToEye => {
    for (const {group, shape, text, towards} of faces) {
      const [right, up, back] = toEye(patientToEye, towards);
      const isSeen = back > 0.02;
      update(group, {visibility: isSeen ? 'visible' : 'hidden'});
      if (isSeen) {
        update(shape, {points: faceCorners(patientToEye, towards)});
        update(text, {x: right * CUBE_HALF, y: -up * CUBE_HALF,
          'fill-opacity': Math.min(1, back * 1.6).toFixed(2)});
      }
    }
  };
}

/**
 * @param {number[]} patientToEye
 * @param {Triple} towards
 */
function faceCorners(patientToEye, towards) {
  const a = /** @type {Triple} */ ([towards[1], towards[2], towards[0]]);
  const b = /** @type {Triple} */ ([towards[2], towards[0], towards[1]]);
  return [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([u, v]) => {
    const corner = /** @type {Triple} */ (towards.map((t, k) => t + u * a[k] + v * b[k]));
    const [right, up] = toEye(patientToEye, corner);
    return `${(right * CUBE_HALF).toFixed(2)},${(-up * CUBE_HALF).toFixed(2)}`;
  }).join(' ');
}
