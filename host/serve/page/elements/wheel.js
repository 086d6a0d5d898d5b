// Events of a mouse wheel and of a touchpad.

const LEAST_NOTCH = 50;     // A larger deltaY comes from a mouse wheel.
const PINCH = 0.009;        // Zoom by deltaY of two fingers on a touchpad, as in the picture.
const NOTCH = 120;          // deltaY of one notch; browsers add up the notches of a fast turn.

/**
 * The notches of a mouse wheel, positive downwards; 0 for a touchpad, which sends many small steps.
 * @param {WheelEvent} event
 */
export function notchesOf({deltaY, deltaMode}) {
  const isPixels = deltaMode === WheelEvent.DOM_DELTA_PIXEL;
  if (isPixels && Math.abs(deltaY) < LEAST_NOTCH) {
    return 0;
  }
  return Math.sign(deltaY) * (isPixels ? Math.max(1, Math.round(Math.abs(deltaY) / NOTCH)) : 1);
}

/**
 * How many times larger a wheel shows things.
 * @param {WheelEvent} event
 * @param {number} step     Of a notch.
 */
export function timesOf(event, step) {
  const notches = notchesOf(event);
  return notches === 0 ? Math.exp(-event.deltaY * PINCH) : step ** -notches;
}
