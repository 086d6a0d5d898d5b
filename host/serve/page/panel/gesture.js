// A field whose gesture is one undo step.

/**
 * Listeners of a slider or a color field. The first `input` of a gesture starts an undo step, and
 * `change` ends the gesture.
 * @param {import('../link/connection.js').Connection} connection
 * @param {() => void} act  Sends the setting.
 */
export function gesture(connection, act) {
  let isUnderWay = false;
  return {
    oninput: () => {
      if (!isUnderWay) {
        isUnderWay = true;
        connection.mark();
      }
      act();
    },
    onchange: () => { isUnderWay = false; },
  };
}
