// Records a page's inputs, messages and frames by the page's clock.

/** Runs in the page before its own code: begins to record into `globalThis.recorded`. */
export function record() {
  const now = () => performance.now();
  const recorded = { inputs: [], sent: [], replies: new Map(), frames: [] };
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
  const look = () => {
    const { frames, revision } = globalThis.pxpl5 ?? { frames: 0 };
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
  recorded.inputs.length = recorded.sent.length = recorded.frames.length = 0;
  recorded.replies.clear();
}

/**
 * Runs in the page: what the inputs led to. An input is displayed by the first frame that shows the
 * revision which the first line sent after it led to: that line says what the input wished, or what
 * a newer one did.
 * @returns {{seconds: number, frames: number, states: number, latency_ms: number[]}} `states`:
 *   different revisions that were shown between the first and the last input
 */
export function evaluate() {
  const { inputs, sent, replies, frames } = globalThis.recorded;
  const [first, last] = [inputs[0], inputs.at(-1)];
  const within = frames.filter(({ at }) => at >= first && at <= last);
  const latency_ms = inputs.flatMap(at => {
    const line = sent.find(each => each.at >= at && replies.has(each.id));
    const revision = replies.get(line?.id);
    const frame = frames.find(each => each.at >= (line?.at ?? Infinity) &&
      each.revision >= revision);
    return frame ? [frame.at - at] : [];
  });
  return { seconds: (last - first) / 1000, frames: within.length,
         states: new Set(within.map(({ revision }) => revision)).size, latency_ms };
}
