// A field whose gesture is one undo step.

const OLD_MS = 400;

/** @type {WeakMap<EventTarget, number>} Times of inputs that no value was equal to yet. */
const touched = new WeakMap();

/**
 * Listeners of a slider or a color field. The first `input` of a gesture starts an undo step, and
 * `change` ends the gesture.
 * @param {import('../link/connection.js').Connection} connection
 * @param {() => void} act  Sends the setting.
 */
export function gesture(connection, act) {
  let isUnderWay = false;
  return {
    oninput: (/** @type {Event} */ {target}) => {
      if (target) {
        touched.set(target, performance.now());
      }
      if (!isUnderWay) {
        isUnderWay = true;
        connection.mark();
      }
      act();
    },
    onchange: () => { isUnderWay = false; },
  };
}

/**
 * Whether a value may be older than the last input of a slider: until the first value that is equal
 * to the input, but not for long.
 * @param {HTMLInputElement | HTMLSelectElement} slider  Its inputs are those of a gesture.
 * @param {string} value
 */
export function mayBeOld(slider, value) {
  if (slider.value === value) {
    touched.delete(slider);
  }
  return slider.matches(':active') ||
    performance.now() - (touched.get(slider) ?? -OLD_MS) < OLD_MS;
}
