// The WebSocket to the server: commands, questions, replies, events, reconnection.
import {say} from '../texts/say.js';
import {parseMessage} from './messages.js';
import {subjectOf, toLine} from './lines.js';

/** @typedef {import('./types.js').Reply} Reply */
/** @typedef {import('./types.js').Answer} Answer */

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 4000;
/** Messages for close codes, if the server gives no reason. */
const CLOSED_BECAUSE = new Map([
  [1008, say`The server closed the connection: too many messages, or not allowed.`],
  [1009, say`The server closed the connection: a message was too long.`],
  [1013, say`The server closed the connection: it is overloaded.`],
]);
const LOST = say`The connection was lost before the server replied.`;

/**
 * @typedef {object} Waiting            The sender of a message, who waits for the reply.
 * @property {string} line              '' for a question.
 * @property {number} sentAt            performance.now().
 * @property {(reply: Reply) => void} reply
 * @property {(answer: Answer) => void} [answer]
 */

/**
 * @typedef {object} Setting            A line that sets a subject, and the callback for its reply.
 * @property {string} line
 * @property {(reply: Reply) => void} reply
 */

/**
 * @typedef {object} Frame
 * @property {import('./types.js').FrameHeader} header
 * @property {Uint8Array} picture       All pictures, encoded as one.
 * @property {Uint8Array[]} depths      Packed, of each picture; empty if there are none.
 * @property {() => void} shown         Reports that the frame is displayed: the next may come.
 */

/**
 * Events, and what listeners get: `hello` Hello, `state` State, `frame` Frame,
 * `progress` Progress or null, `machine` any, `note` Note, `open` (connected), `lost` a sentence,
 * `reply` {line, reply, sentAt}, `failed` {line, error, isOwn} of a `do` or `set` that was refused,
 * or of a message that cannot be read: then the line is ''. isOwn: see Reply.
 * @typedef {'hello' | 'state' | 'frame' | 'progress' | 'machine' | 'note' | 'open' | 'lost'
 *   | 'reply' | 'failed'} EventName
 */

export class Connection {
  /** @param {URL} url  ws: or wss:, with the token if there is one. */
  constructor(url) {
    /** @private */
    this.url_ = url;
    /** @private @type {WebSocket | null} */
    this.socket_ = null;
    /** @private */
    this.nextId_ = 1;
    /** @private @type {Map<number, Waiting>} */
    this.waiting_ = new Map();
    /** @private @type {Map<string, Setting>} the newest that was sent, per subject */
    this.underWay_ = new Map();
    /** @private @type {Map<string, Setting>} the newest that waits for it; in order of arrival */
    this.newest_ = new Map();
    /** @private @type {Map<EventName, Set<(what: any) => void>>} */
    this.listeners_ = new Map();
    /** @private */
    this.waitMs_ = FIRST_WAIT_MS;
    /** @private */
    this.wantsMachine_ = false;
    /** @private performance.now() of the last message. */
    this.heardAt_ = 0;
    /** @type {import('./types.js').Hello | null} */
    this.hello = null;
  }

  /** Connects, and reconnects after each loss. Call once, after adding all listeners. */
  open() {
    const socket = new WebSocket(this.url_);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.emit_('open', null);
      if (this.wantsMachine_) {
        this.send_({panel: true});
      }
    };
    socket.onmessage = event => this.take_(event.data);
    socket.onclose = event => this.lost_(event);
    this.socket_ = socket;
  }

  get connected() {
    return this.socket_?.readyState === WebSocket.OPEN;
  }

  /** Time for which the server has been silent although it was asked; 0 if nothing was asked. */
  get silent_ms() {
    const [oldest] = this.waiting_.values();
    return oldest ? performance.now() - Math.max(oldest.sentAt, this.heardAt_) : 0;
  }

  /** Asks the server for a sign of life, unless something else is asked. */
  ping() {
    if (this.waiting_.size === 0) {
      this.request_({ping: true}, {line: '', sentAt: performance.now(), reply: () => {}});
    }
  }

  /** Whether this page is view-only. */
  get watches() {
    return this.hello?.role === 'watcher';
  }

  /**
   * @param {EventName} name
   * @param {(what: any) => void} act
   * @returns {() => void} ends it
   */
  on(name, act) {
    const acts = this.listeners_.get(name) ?? new Set();
    this.listeners_.set(name, acts.add(act));
    return () => void acts.delete(act);
  }

  /**
   * Runs a command line after all waiting settings. The promise never rejects. A failure also
   * raises the event `failed`, so callers need not show the error.
   * @param {string} line
   * @param {{quiet?: boolean}} [options]  quiet: the caller shows failures itself.
   * @returns {Promise<Reply>}
   */
  do(line, options = {}) {
    // An earlier setting must not arrive later: the server keeps the newest per subject.
    for (const [subject, setting] of [...this.newest_]) {
      this.sendSetting_(subject, setting);
    }
    return this.sendLine_(line, options);
  }

  /**
   * Runs a setting, newest only, for drags. Per subject (see `subjectOf`) one line is in flight and
   * the newest line waits. Lines between them are answered `superseded`. Lines that are not
   * settings run as with `do`.
   * @param {import('./lines.js').Command} command
   * @returns {Promise<Reply>}
   */
  set(command) {
    const line = toLine(command);
    const subject = subjectOf(command, this.hello?.commands ?? []);
    if (subject === '') {
      return this.do(line);
    }
    return new Promise(reply => {
      if (!this.underWay_.has(subject)) {
        this.sendSetting_(subject, {line, reply});
        return;
      }
      this.newest_.get(subject)?.reply({ok: false, superseded: true});
      this.newest_.delete(subject);
      this.newest_.set(subject, {line, reply});
    });
  }

  /**
   * Sends a question whose answer contains bytes.
   * @param {{ask: string, [key: string]: unknown}} question
   * @returns {Promise<Answer>} rejected with a sentence if it fails
   */
  ask(question) {
    return new Promise((answer, reject) => {
      const reply = (/** @type {Reply} */ failed) => reject(new Error(failed.error ?? LOST));
      if (this.request_(question, {line: '', sentAt: performance.now(), reply, answer}) === 0) {
        reject(new Error(say`Not connected.`));
      }
    });
  }

  /**
   * Asks for a pair of pictures for the eyes of a headset, newest only.
   * @param {object | null} eyes  As host/serve/README.md describes them; null ends it.
   * @returns {Promise<Reply>} Never rejected. The pair arrives as a frame.
   */
  eyes(eyes) {
    return new Promise(reply => {
      if (this.request_({eyes}, {line: '', sentAt: performance.now(), reply}) === 0) {
        reply({ok: false, error: say`Not connected.`, isOwn: true});
      }
    });
  }

  /** Starts a new undo step. */
  mark() {
    void this.do('mark', {quiet: true});
  }

  /** Cancels the current long work. */
  cancel() {
    this.send_({cancel: true});
  }

  /**
   * Turns `machine` messages on or off. Reconnections keep the choice.
   * @param {boolean} wanted
   */
  wantMachine(wanted) {
    this.wantsMachine_ = wanted;
    this.send_({panel: wanted});
  }

  /**
   * Asks for depths with the frames of this connection, or for none.
   * @param {boolean} wanted
   */
  wantDepths(wanted) {
    this.send_({depths: wanted});
  }

  /**
   * Asks for moving pictures as video if the link is slow, beginning with a key frame; or for none.
   * @param {boolean} wanted
   */
  wantVideo(wanted) {
    this.send_({video: wanted});
  }

  /**
   * @private
   * @param {string} line
   * @param {{quiet?: boolean}} options
   * @returns {Promise<Reply>}
   */
  sendLine_(line, {quiet = false}) {
    return new Promise(resolve => {
      const reply = (/** @type {Reply} */ answer) => {
        if (!answer.ok && !answer.superseded && !quiet) {
          this.emit_('failed', {line, error: answer.error ?? '', isOwn: answer.isOwn ?? false});
        }
        resolve(answer);
      };
      const id = this.request_({do: line}, {line, sentAt: performance.now(), reply});
      if (id === 0) {
        reply({ok: false, error: say`Not connected: nothing was changed.`, isOwn: true});
      }
    });
  }

  /**
   * Sends a setting. After the reply, sends the newest waiting setting of the subject.
   * @private
   * @param {string} subject
   * @param {Setting} setting
   */
  sendSetting_(subject, setting) {
    this.newest_.delete(subject);
    this.underWay_.set(subject, setting);
    this.sendLine_(setting.line, {}).then(reply => {
      setting.reply(reply);
      if (this.underWay_.get(subject) !== setting) {
        return;  // `do` has sent a newer setting, whose reply is pending.
      }
      this.underWay_.delete(subject);
      const next = this.newest_.get(subject);
      if (next) {
        this.sendSetting_(subject, next);
      }
    });
  }

  /**
   * @private
   * @param {object} message
   * @param {Waiting} waiting
   * @returns {number} the message's id, 0 if there is no connection
   */
  request_(message, waiting) {
    const id = this.nextId_++;
    if (!this.send_({id, ...message})) {
      return 0;
    }
    this.waiting_.set(id, waiting);
    return id;
  }

  /**
   * @private
   * @param {object} message
   */
  send_(message) {
    if (!this.connected) {
      return false;
    }
    this.socket_?.send(JSON.stringify(message));
    return true;
  }

  /**
   * @private
   * @param {string | ArrayBuffer} data
   */
  take_(data) {
    this.heardAt_ = performance.now();
    if (typeof data === 'string') {
      this.takeText_(JSON.parse(data));
      return;
    }
    let message;
    try {
      message = parseMessage(data);
    } catch (error) {
      const why = error instanceof Error ? error.message : String(error);
      this.emit_('failed', {line: '', error: why, isOwn: true});
      return;
    }
    if ('header' in message) {
      this.takeFrame_(message);
    } else {
      const {id, json, bytes} = message;
      this.waiting_.get(id)?.answer?.({json, bytes});
      this.waiting_.delete(id);
    }
  }

  /**
   * @private
   * @param {ReturnType<typeof import('./messages.js').parseFrame>} message
   */
  takeFrame_({header, picture, depths}) {
    const from = this.socket_, arrived = this.heardAt_;
    const shown = () => {
      // A later connection numbers its own frames.
      if (from === this.socket_) {
        const after_ms = Math.round((performance.now() - arrived) * 10) / 10;
        this.send_({shown: header.number, after_ms});
      }
    };
    this.emit_('frame', {header, picture, depths, shown});
  }

  /**
   * @private
   * @param {any} message
   */
  takeText_(message) {
    if ('re' in message) {
      const waiting = this.waiting_.get(message.re);
      this.waiting_.delete(message.re);
      waiting?.reply(message);
      if (waiting) {
        this.emit_('reply', {line: waiting.line, reply: message, sentAt: waiting.sentAt});
      }
      return;
    }
    if ('hello' in message) {
      this.waitMs_ = FIRST_WAIT_MS;
      this.hello = message.hello;
    }
    const names = /** @type {const} */ (['hello', 'state', 'progress', 'machine', 'note']);
    for (const name of names) {
      if (name in message) {
        this.emit_(name, message[name]);
      }
    }
  }

  /**
   * @private
   * @param {{code: number, reason: string}} closed
   */
  lost_({code, reason}) {
    this.socket_ = null;
    const waiting = [...this.waiting_.values()];
    this.waiting_.clear();
    this.emit_('lost', reason === '' ? CLOSED_BECAUSE.get(code) ?? ''
      : say`The server closed the connection: ${reason}`);
    for (const {reply} of waiting) {
      reply({ok: false, superseded: false, error: LOST, isOwn: true});
    }
    setTimeout(() => this.open(), this.waitMs_);
    this.waitMs_ = Math.min(this.waitMs_ * 2, LONGEST_WAIT_MS);
  }

  /**
   * @private
   * @param {EventName} name
   * @param {any} what
   */
  emit_(name, what) {
    for (const act of this.listeners_.get(name) ?? []) {
      act(what);
    }
  }
}
