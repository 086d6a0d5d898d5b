// Limits how often something is done.

/**
 * Returns a function that calls `act` at once, but not again for a time. Calls in between lead to
 * one call at the end of this time, so the last one always has its effect.
 * @param {() => void} act
 * @param {number} ms
 * @param {() => number} [now]  Milliseconds of a clock.
 */
export function paced(act, ms, now = () => performance.now()) {
  let last = -Infinity, isWaiting = false;
  const run = () => {
    isWaiting = false;
    last = now();
    act();
  };
  return () => {
    const left = last + ms - now();
    if (!isWaiting && left > 0) {
      isWaiting = true;
      setTimeout(run, left);
    } else if (!isWaiting) {
      run();
    }
  };
}
