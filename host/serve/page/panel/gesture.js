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
      touch(target);
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
 * Notes an input, for mayBeOld().
 * @param {EventTarget | null} field
 */
export function touch(field) {
  if (field) {
    touched.set(field, performance.now());
  }
}

/**
 * Whether a value may be older than the last input of a field: until the first value that is equal
 * to the input, but not for long.
 * @param {HTMLInputElement | HTMLSelectElement} field  touch() notes its inputs.
 * @param {string | boolean} value  Of a checkbox: whether it is checked.
 */
export function mayBeOld(field, value) {
  const now = 'checked' in field && field.type === 'checkbox' ? field.checked : field.value;
  if (now === value) {
    touched.delete(field);
  }
  return field.matches(':active') ||
    performance.now() - (touched.get(field) ?? -OLD_MS) < OLD_MS;
}
