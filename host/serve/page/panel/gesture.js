// A field whose gesture is one undo step.

const OLD_MS = 400;

/** @typedef {HTMLInputElement | HTMLSelectElement} Field */

/** @type {WeakMap<EventTarget, number>} Times of inputs that no value was equal to yet. */
const touched = new WeakMap();
/** @type {WeakMap<Field, string | boolean>} The newest values of fields that did not take one. */
const later = new WeakMap();

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
 * @param {Field} field  touch() notes its inputs.
 * @param {string | boolean} value  Of a checkbox: whether it is checked.
 */
export function mayBeOld(field, value) {
  const now = isTick(field) ? field.checked : field.value;
  if (now === value) {
    touched.delete(field);
  }
  return field.matches(':active') ||
    performance.now() - (touched.get(field) ?? -OLD_MS) < OLD_MS;
}

/**
 * Shows a value unless the user is editing the field. A slider and a checkbox keep the focus when
 * the user has used them, and show what follows, for example an undo. A value that may be old is
 * shown later, unless a newer one comes.
 * @param {Field} field
 * @param {string | boolean} value  Of a checkbox: whether it is checked.
 */
export function show(field, value) {
  const isUsed = field.type === 'range' || isTick(field);
  const waits = later.has(field);
  if (waits) {
    later.set(field, value);
  }
  if (isUsed && mayBeOld(field, value)) {
    if (!waits) {
      later.set(field, value);
      setTimeout(() => {
        const newest = later.get(field) ?? value;
        later.delete(field);
        show(field, newest);
      }, OLD_MS);
    }
  } else if (isTick(field)) {
    field.checked = Boolean(value);
  } else if (isUsed || document.activeElement !== field) {
    field.value = String(value);
  }
}

/**
 * @param {Field} field
 * @returns {field is HTMLInputElement}
 */
function isTick(field) {
  return field.type === 'checkbox';
}
