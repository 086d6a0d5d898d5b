// Ends of measurements in the picture: dragged, or moved by keys, from surface to surface.
import {PART_STAYS, isRegion, through} from '../panel/measures.js';
import {sentenceOf} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/measures.js').Measure} Measure */
/** @typedef {import('../panel/app.js').Eye} Eye */
/**
 * An end that a pointer drags.
 * @typedef {{name: string, end: number, eye: Eye['name'], x: number, y: number}} Held  Places.
 */

const MOUSE_REACH = 12, FINGER_REACH = 22;   // CSS pixels.
const NOWHERE = say`There is no surface. The end is back in its place.`;
const OUTSIDE = say`The pointer is outside of the picture. The end is back in its place.`;

/**
 * How far from an end a pointer grabs it.
 * @param {PointerEvent} event
 */
export function reachOf(event) {
  return event.pointerType === 'touch' ? FINGER_REACH : MOUSE_REACH;
}

export class MeasureEnds {
  /**
   * @param {import('../panel/app.js').App} app
   * @param {{say: (text: string) => void, fail: (text: string) => void}} message
   * @param {{grabs: (measure: Measure) => boolean, changed: () => void}} panel  Whether a pointer
   *     grabs the ends of a measurement now; a dragged end is at another place.
   */
  constructor(app, message, panel) {
    /** @private */ this.app_ = app;
    /** @private */ this.message_ = message;
    /** @private */ this.panel_ = panel;
    /** @type {Held | null} */
    this.held = null;
    /** Ends after all movements so far. @private */ this.moved_ = Promise.resolve();
    /** @type {import('../panel/measure_list.js').Mover} */
    this.mover = {
      refusal: measure => this.refusal_(measure),
      hint: say`Arrow keys move it by a pixel along the surface, with Shift by 10.`,
      look: () => {},
      move: ({name}, end, across, down) => {
        const {jumps} = app.measures;
        // Undo ends the movements before it.
        this.moved_ = this.moved_.then(() =>
          app.measures.jumps === jumps ? this.step_(name, end, across, down) : undefined);
      },
      leave: () => { this.moved_ = this.moved_.then(() => app.measures.drop()); },
    };
    app.grabs.at = event => this.at_(event);
    const {stage} = app.picture;
    stage.addEventListener('pointermove', event => {
      if (event.buttons === 0) {
        stage.classList.toggle('grabs', this.at_(event) !== null);
      }
    });
  }

  /**
   * @private
   * @param {Measure} measure
   */
  refusal_({kind}) {
    return this.app_.connection.watches ? say`A view-only page moves ends in slices alone.`
      : kind === 'part' ? PART_STAYS
      : isRegion(kind) ? say`The corners of regions move in the tab Slices.` : '';
  }

  /**
   * The nearest end under a pointer.
   * @private
   * @param {PointerEvent} event
   * @returns {import('../panel/app.js').Grab | null}
   */
  at_(event) {
    const {picture, measures} = this.app_;
    const at = this.placeOf_(event);
    let [least, held] = [reachOf(event), /** @type {Held | null} */ (null)];
    for (const eye of picture.eyes()) {
      for (const measure of measures.seen) {
        if (this.refusal_(measure) || !this.panel_.grabs(measure)) {
          continue;
        }
        measure.points_mm.forEach((p_mm, end) => {
          const {x, y, visible} = eye.project(p_mm);
          const far = Math.hypot(x - at.x, y - at.y);
          if (visible && far <= least) {
            least = far;
            held = {name: measure.name, end, eye: eye.name, ...at};
          }
        });
      }
    }
    return held && this.grab_(held);
  }

  /**
   * @private
   * @param {Held} held
   * @returns {import('../panel/app.js').Grab}
   */
  grab_(held) {
    const show = (/** @type {Held | null} */ now) => {
      this.held = now;
      this.panel_.changed();
    };
    return {
      move: event => show({...held, ...this.placeOf_(event)}),
      drop: event => {
        const place = this.app_.picture.placeAt(event);
        this.moved_ = this.moved_.then(async () => {
          const pixel = place && this.app_.picture.pixelOf(place);
          const sentence = pixel ? await this.put_(held.name, held.end, pixel) : OUTSIDE;
          if (sentence) {
            this.message_.fail(sentence);
          }
          this.app_.measures.drop();
          show(null);
        });
      },
      cancel: () => show(null),
    };
  }

  /**
   * Puts an end on the surface at a pixel. Returns why it stays; empty if it moves.
   * @private
   * @param {string} name
   * @param {number} end
   * @param {{x: number, y: number}} pixel
   */
  async put_(name, end, {x, y}) {
    const {connection, measures} = this.app_;
    const measure = measures.named(name);
    const {ok, error = '', result} = await connection.do(`pick ${x} ${y}`, {quiet: true});
    if (!measure || measure !== measures.named(name)) {
      return '';  // It was deleted meanwhile, or moved by an undo.
    }
    if (!ok || !result?.hit) {
      return ok ? NOWHERE : error;
    }
    const points = measure.points_mm.map((p_mm, k) => k === end ? result.p_mm : p_mm);
    try {
      measures.drag(name, through(measure.kind, points));
      return '';
    } catch (same) {
      return sentenceOf(same);
    }
  }

  /**
   * Moves an end by pixels. It stays on the surface.
   * @private
   * @param {string} name
   * @param {number} end
   * @param {number} across
   * @param {number} down
   */
  async step_(name, end, across, down) {
    const {picture, measures} = this.app_;
    const [p_mm, eye] = [measures.named(name)?.points_mm[end], picture.eyes()[0]];
    if (!p_mm || !eye) {
      return;
    }
    const place = eye.project(p_mm);
    const pixel = picture.pixelOf({x: place.x / picture.width, y: place.y / picture.height});
    const sentence = place.visible
      ? await this.put_(name, end, {x: pixel.x + across, y: pixel.y + down})
      : say`This end is not in the picture. Turn the picture until it shows the end.`;
    if (sentence) {
      this.message_.fail(sentence);
    } else {
      this.message_.say(this.mover.hint);
    }
  }

  /**
   * The place of the overlay under a pointer.
   * @private
   * @param {PointerEvent} event
   */
  placeOf_({clientX, clientY}) {
    const {left, top} = this.app_.picture.overlay.getBoundingClientRect();
    return {x: clientX - left, y: clientY - top};
  }
}
