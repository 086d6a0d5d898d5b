// Common parts of the dialog "Save".
import {h} from '../elements/dom.js';
import {LIMITS} from '../link/vocabulary.js';
import {sentenceOf} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */

/** A side of a picture that the commands accept. */
export const MOST_PX = LIMITS.max_user_picture_px;
export const FREE = 'free';
export const SAMPLES = /** @type {const} */ ([['16', say`16 samples`],
  ['4', say`4 samples`], ['1', say`1 sample`]]);

/**
 * The volume's name without characters that a file name cannot have.
 * @param {App} app
 */
export function baseName({store}) {
  return (store.state?.volume?.name ?? 'pxpl5').replace(/[^\w.-]+/g, '-');
}

/**
 * @param {readonly (readonly [string, string])[]} choices
 * @param {string} label
 * @param {string} testid
 */
export function choice(choices, label, testid) {
  return h('select', {'aria-label': label, title: label, 'data-testid': testid},
    ...choices.map(([value, text]) => h('option', {value}, text)));
}

/**
 * A number, checked when it is used: the dialog then says what is wrong.
 * @param {string} name   For screen readers and errors.
 * @param {{value: number | string, low: number, high: number, highText?: string,
 *   isWhole?: boolean}} limits  With a text for `high`, if it has a unit.
 * @param {string} testid
 */
export function numberInput(name, {value, low, high, highText = `${high}`, isWhole = true},
  testid) {
  const input = h('input', {type: 'number', min: low, max: high, step: isWhole ? 1 : 'any', value,
    class: 'px', 'aria-label': name, title: name, 'data-testid': testid});
  return {
    input,
    /** @throws {Error} with a sentence, if the number is out of range */
    value: () => {
      const number = Number(input.value);
      if (input.value.trim() === '' || number < low || number > high
          || isWhole && !Number.isInteger(number)) {
        throw new Error(isWhole
          ? say`${name} is "${input.value}", must be a whole number from ${low} to ${highText}.`
          : say`${name} is "${input.value}", must be a number from ${low} to ${highText}.`);
      }
      return number;
    },
  };
}

/**
 * Runs what a button of the dialog does. Shows an error in the dialog, while it is open.
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 * @param {HTMLElement} wrong
 * @param {() => Promise<void>} act
 */
export async function attempt(app, dialog, wrong, act) {
  try {
    await act();
  } catch (error) {
    if (dialog.open) {
      wrong.textContent = sentenceOf(error);
      wrong.hidden = false;
    } else {
      app.toasts.error(sentenceOf(error));
    }
  }
}

/** @param {string} testid */
export function wrongLine(testid) {
  return h('p', {class: 'wrong', role: 'alert', hidden: true, 'data-testid': testid});
}

/**
 * All sides grow by the same factor, up to MOST_PX.
 * @param {number[]} size
 * @param {number} factor
 */
function enlarged(size, factor) {
  const least = Math.min(factor, MOST_PX / Math.max(...size));
  return size.map(side => Math.round(side * least));
}

/**
 * The size of one eye's picture. Chosen sizes are those of the file, which may have both eyes side
 * by side.
 * @param {App} app
 * @param {ReturnType<typeof sizeChoice>} choice
 * @throws {Error} with a sentence, if a side is out of range
 */
export function eyeSize({store, picture}, choice) {
  const shown = store.state?.size ?? [1, 1], whole = picture.wholeSize(shown);
  return choice.size(whole).map((side, axis) =>
    Math.max(1, Math.round(side * shown[axis] / whole[axis])));
}

/**
 * A choice of sizes: multiples of the size on the screen, usual sizes, or any.
 * @param {readonly (readonly [string, string])[]} choices  Factors, WIDTHxHEIGHT, or FREE.
 * @param {string} testid
 */
export function sizeChoice(choices, testid) {
  const list = choice(choices, say`Size`, testid);
  const limits = {low: 1, high: MOST_PX, highText: say`${MOST_PX} pixels`};
  const width = numberInput(say`Width`, {...limits, value: 1600}, `${testid}-width`);
  const height = numberInput(say`Height`, {...limits, value: 1200}, `${testid}-height`);
  const free = h('span', {class: 'row', hidden: true}, width.input, '×', height.input,
    say`pixels`);
  list.addEventListener('change', () => {
    free.hidden = list.value !== FREE;
  });
  return {
    list, free,
    /**
     * @param {number[]} shown  The size on the screen.
     * @returns {number[]}
     * @throws {Error} with a sentence, if a side is out of range
     */
    size: shown => list.value === FREE ? [width.value(), height.value()]
      : list.value.includes('x') ? list.value.split('x').map(Number)
        : enlarged(shown, Number(list.value)),
  };
}
