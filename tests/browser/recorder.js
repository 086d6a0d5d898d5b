// Records a page's inputs, messages and frames by the page's clock.

/** Runs in the page before its own code: begins to record into `globalThis.recorded`. */
export function record() {
  const now = () => performance.now();
  const recorded = { inputs: [], sent: [], replies: new Map(), frames: [], changes: [] };
  globalThis.recorded = recorded;
  const Plain = globalThis.WebSocket;
  globalThis.WebSocket = class extends Plain {
    constructor(...words) {
      super(...words);
      this.addEventListener('message', ({ data }) => {
        if (typeof data !== 'string' || !data.startsWith('{"re"')) return;
        const { re, ok, revision } = JSON.parse(data);
        if (ok) recorded.replies.set(re, revision);
      });
    }
    send(text) {
      const { id, do: line } = JSON.parse(text);
      if (line && line !== 'mark') recorded.sent.push({ id, at: now() });
      super.send(text);
    }
  };
  addEventListener('pointermove', event => {
    if (event.buttons !== 0) recorded.inputs.push(event.timeStamp);
  }, { capture: true });
  let before = '';
  const look = () => {
    const { frames, revision, warp } = globalThis.pxpl5 ?? { frames: 0 };
    const shown = `${frames} ${warp?.draws}`;
    if (shown !== before) recorded.changes.push(now());
    before = shown;
    if (frames > (recorded.frames.at(-1)?.frames ?? 0)) {
      recorded.frames.push({ frames, revision, at: now() });
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

/** Runs in the page: forgets what was recorded. */
export function forget() {
  const { recorded } = globalThis;
  for (const list of ['inputs', 'sent', 'frames', 'changes']) recorded[list].length = 0;
  recorded.replies.clear();
}

/**
 * Runs in the page: what the inputs led to. An input is displayed by the first frame that shows the
 * revision which the first line sent after it led to: that line says what the input wished, or what
 * a newer one did.
 * @returns {{seconds: number, inputs: number, frames: number, changes: number, states: number,
 *   latency_ms: number[]}} all between the first and the last input. `frames`: pictures of the
 *   machine that were shown; `changes`: refreshes of the screen with a new picture of the machine
 *   or a new warped picture; `states`: different revisions that were shown
 */
export function evaluate() {
  const { inputs, sent, replies, frames, changes } = globalThis.recorded;
  const [first, last] = [inputs[0], inputs.at(-1)];
  const within = frames.filter(({ at }) => at >= first && at <= last);
  const latency_ms = inputs.flatMap(at => {
    const line = sent.find(each => each.at >= at && replies.has(each.id));
    const revision = replies.get(line?.id);
    const frame = frames.find(each => each.at >= (line?.at ?? Infinity) &&
      each.revision >= revision);
    return frame ? [frame.at - at] : [];
  });
  return { seconds: (last - first) / 1000, inputs: inputs.length, frames: within.length,
         changes: changes.filter(at => at >= first && at <= last).length,
         states: new Set(within.map(({ revision }) => revision)).size, latency_ms };
}
