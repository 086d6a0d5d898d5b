// Holds messages of the server back, so that a test sees the page between two of them.

/**
 * Runs in the page before its own code. `globalThis.holds` is 'binary' (frames and answers),
 * 'state' or '' (nothing). `globalThis.release()` delivers what was held. `globalThis.replies`
 * counts replies.
 */
export function holdMessages() {
  const Plain = globalThis.WebSocket;
  const held = [];
  globalThis.holds = '';
  globalThis.replies = 0;
  globalThis.release = () => {
    globalThis.holds = '';
    while (held.length > 0) held.shift()();
  };
  const isHeld = data => globalThis.holds === 'binary' && typeof data !== 'string' ||
    globalThis.holds === 'state' && typeof data === 'string' && data.startsWith('{"state"');
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        if (isHeld(event.data)) held.push(() => take(event));
        else take(event);
        if (typeof event.data === 'string' && event.data.startsWith('{"re"')) ++globalThis.replies;
      });
    }
  };
}
