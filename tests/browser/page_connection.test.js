// The page's side of the protocol, against a socket that the test holds in its hand.
import assert from 'node:assert/strict';
import test, {mock} from 'node:test';

import {Connection} from '../../host/serve/page/link/connection.js';
import {ANSWER_HEADER_BYTES, ANSWER_HEADER_MAGIC, FRAME_HEADER_BYTES, FRAME_HEADER_MAGIC}
  from '../../host/serve/page/link/vocabulary.js';
import {PictureView} from '../../host/serve/page/picture/picture.js';
import {Store} from '../../host/serve/page/state/store.js';

/** The settings of the server's table that these tests use. */
const TABLE = [['surface', 1], ['view', 0], ['tint', 0], ['clip', 1]].map(
  ([name, subject_words]) => ({name, kind: 'setting', subject_words}));

/** @param {string} line  Without quotes. */
function command(line) {
  const [name, ...rest] = line.split(' ');
  const isOption = (/** @type {string} */ each) => each.includes('=');
  return {name, words: rest.filter(each => !isOption(each)),
    options: Object.fromEntries(rest.filter(isOption).map(each => each.split('=')))};
}

/** The part of the browser's WebSocket that the page uses. */
class HandSocket {
  static OPEN = 1;
  /** @type {HandSocket[]} */
  static all = [];

  constructor() {
    this.readyState = 0;
    /** @type {any[]} */
    this.sent = [];
    HandSocket.all.push(this);
  }

  /** @param {string} text */
  send(text) {
    this.sent.push(JSON.parse(text));
  }

  accept() {
    this.readyState = 1;
    this.onopen();
    this.say({hello: {version: '1', role: 'driver', viewer: 1, topology: 'default',
      commands: TABLE}});
  }

  /** @param {object | ArrayBuffer} what */
  say(what) {
    this.onmessage({data: what instanceof ArrayBuffer ? what : JSON.stringify(what)});
  }

  /** @param {number} code */
  drop(code, reason = '') {
    this.readyState = 3;
    this.onclose({code, reason});
  }
}
globalThis.WebSocket = /** @type {any} */ (HandSocket);

function connected() {
  HandSocket.all = [];
  const connection = new Connection(new URL('ws://localhost/socket'));
  connection.open();
  const [socket] = HandSocket.all;
  socket.accept();
  return {connection, socket};
}

/** All that has been settled is told. */
const settled = () => new Promise(resolve => setImmediate(resolve));

test('of a flood of settings, the first and the newest are sent', async () => {
  const {connection, socket} = connected();
  const replies = Array.from({length: 100},
    (_, k) => connection.set(command(`surface bone iso=${k}`)));
  assert.deepEqual(socket.sent.map(({do: line}) => line), ['surface bone iso=0']);
  socket.say({re: socket.sent[0].id, ok: true, revision: 2});
  await settled();
  assert.deepEqual(socket.sent.map(({do: line}) => line),
    ['surface bone iso=0', 'surface bone iso=99']);
  socket.say({re: socket.sent[1].id, ok: true, revision: 3});
  const all = await Promise.all(replies);
  assert.deepEqual([all[0].ok, all[99].ok], [true, true]);
  assert.ok(all.slice(1, 99).every(({superseded}) => superseded));
  // Nothing waits any more: the next goes out at once.
  void connection.set(command('surface bone iso=5'));
  await settled();
  assert.equal(socket.sent.length, 3);
});

test('settings of different things do not wait for each other', () => {
  const {connection, socket} = connected();
  void connection.set(command('surface bone iso=1'));
  void connection.set(command('surface skin iso=1'));
  void connection.set(command('view 1 2'));
  assert.equal(socket.sent.length, 3);
});

test('a refusal is told once, and answers the caller; one that was replaced is none', async () => {
  const {connection, socket} = connected();
  /** @type {string[]} */
  const told = [];
  connection.on('failed', ({error}) => told.push(error));
  const first = connection.do('surface x'), quiet = connection.do('histogram', {quiet: true});
  const replaced = connection.do('view 1 2');
  socket.say({re: socket.sent[0].id, ok: false, error: 'surface x is new'});
  socket.say({re: socket.sent[1].id, ok: false, error: 'no volume'});
  socket.say({re: socket.sent[2].id, ok: false, superseded: true});
  assert.equal((await first).error, 'surface x is new');
  assert.equal((await quiet).error, 'no volume');
  assert.equal((await replaced).superseded, true);
  assert.deepEqual(told, ['surface x is new']);
});

test('a message that cannot be read is an error that the user sees', async () => {
  const {connection, socket} = connected();
  /** @type {{line: string, error: string, isOwn: boolean}[]} */
  const failed = [];
  connection.on('failed', what => failed.push(what));
  const frame = new DataView(new ArrayBuffer(FRAME_HEADER_BYTES - 1));
  frame.setUint32(0, FRAME_HEADER_MAGIC, true);
  const answer = new DataView(new ArrayBuffer(ANSWER_HEADER_BYTES - 1));
  answer.setUint32(0, ANSWER_HEADER_MAGIC, true);
  for (const {buffer} of [frame, answer, new DataView(new ArrayBuffer(3))]) {
    socket.say(/** @type {ArrayBuffer} */ (buffer));
  }
  assert.deepEqual(failed.map(({line, isOwn}) => [line, isOwn]), Array(3).fill(['', true]));
  const [ofFrame, ofAnswer, ofOther] = failed.map(({error}) => error);
  assert.match(ofFrame, /^Frame: 55 bytes, its header has 56\. Load the page again;/);
  assert.match(ofAnswer, /^Answer: 15 bytes, its header has 16\. Load/);
  assert.match(ofOther, /^Message: 3 bytes, neither a frame nor an answer\. Load/);
});

test('an error says whether it is the page\'s own', async () => {
  const {connection, socket} = connected();
  const refused = connection.do('surface bone iso=1', {quiet: true});
  socket.say({re: socket.sent[0].id, ok: false, error: 'surface: no volume is open'});
  assert.equal((await refused).isOwn ?? false, false);
  const lost = connection.do('surface bone iso=2', {quiet: true});
  socket.drop(1006);
  assert.equal((await lost).isOwn, true);
  assert.equal((await connection.do('surface bone iso=3', {quiet: true})).isOwn, true);
});

test('a lost connection answers everybody, comes back, and wants the same', async () => {
  mock.timers.enable({apis: ['setTimeout']});
  const {connection, socket} = connected();
  connection.wantMachine(true);
  const reply = connection.do('load phantom:pelvis', {quiet: true});
  const drag = connection.set(command('view 1 2')), newest = connection.set(command('view 3 4'));
  const answer = connection.ask({ask: 'slice', axis: 'x', index: 0});
  const failed = answer.then(() => 'answered', error => error.message);
  socket.drop(1006);
  assert.match((await reply).error ?? '', /lost/);
  assert.match((await drag).error ?? '', /lost/);
  assert.match((await newest).error ?? '', /Not connected/);
  assert.match(await failed, /lost/);
  assert.equal((await connection.do('digest', {quiet: true})).ok, false);
  mock.timers.tick(250);
  assert.equal(HandSocket.all.length, 2);
  HandSocket.all[1].accept();
  assert.deepEqual(HandSocket.all[1].sent, [{panel: true}]);
  mock.timers.reset();
});

test('tries to come back ever more slowly, and in vain for at most four seconds', () => {
  mock.timers.enable({apis: ['setTimeout']});
  const {socket} = connected();
  socket.drop(1006);
  for (const wait of [250, 500, 1000, 2000, 4000, 4000]) {
    const before = HandSocket.all.length;
    mock.timers.tick(wait - 1);
    assert.equal(HandSocket.all.length, before, `tried again before ${wait} ms`);
    mock.timers.tick(1);
    assert.equal(HandSocket.all.length, before + 1, `did not try after ${wait} ms`);
    HandSocket.all.at(-1)?.drop(1006);
  }
  mock.timers.reset();
});

test('a question is answered by bytes, or refused with the server\'s sentence', async () => {
  const {connection, socket} = connected();
  const good = connection.ask({ask: 'slice', axis: 'z', index: 3});
  const bad = connection.ask({ask: 'slice', axis: 'w', index: 3}).catch(error => error.message);
  assert.deepEqual(socket.sent[0], {id: socket.sent[0].id, ask: 'slice', axis: 'z', index: 3});
  const message = new ArrayBuffer(32);
  const view = new DataView(message);
  [0x4e413550, socket.sent[0].id, 2, 0].forEach((value, k) => view.setUint32(4 * k, value, true));
  new Uint8Array(message).set(new TextEncoder().encode('{}'), 16);
  view.setUint8(24, 77);
  socket.say(message);
  socket.say({re: socket.sent[1].id, ok: false, error: 'axis \'w\' is none of x, y, z'});
  assert.equal(new Uint8Array((await good).bytes)[0], 77);
  assert.equal(await bad, 'axis \'w\' is none of x, y, z');
});

/** @param {HandSocket} socket */
const linesOf = socket => socket.sent.map(({do: line}) => line);

test('what was set before a command or a mark is sent before it', async () => {
  const {connection, socket} = connected();
  const replies = [1, 2, 3].map(iso => connection.set(command(`surface bone iso=${iso}`)));
  const undo = connection.do('undo');
  assert.deepEqual(linesOf(socket), ['surface bone iso=1', 'surface bone iso=3', 'undo']);
  void connection.set(command('surface bone iso=4'));
  connection.mark();
  assert.deepEqual(linesOf(socket).slice(3), ['surface bone iso=4', 'mark']);
  // The first's answer lets nothing go: a newer one is under way.
  void connection.set(command('surface bone iso=5'));
  socket.say({re: socket.sent[0].id, ok: true});
  await settled();
  assert.equal(socket.sent.length, 5);
  for (const {id} of socket.sent.slice(1)) {
    socket.say({re: id, ok: true});
  }
  await settled();
  assert.deepEqual(linesOf(socket).slice(5), ['surface bone iso=5']);
  assert.deepEqual((await Promise.all(replies)).map(({ok}) => ok), [true, false, true]);
  assert.equal((await undo).ok, true);
});

test('settings that wait are sent in the order in which they came', () => {
  const {connection, socket} = connected();
  for (const line of ['view 0 0', 'view zoom=1', 'view 1 1', 'view zoom=2', 'view 2 2']) {
    void connection.set(command(line));
  }
  void connection.do('view anterior');
  assert.deepEqual(linesOf(socket).slice(2), ['view zoom=2', 'view 2 2', 'view anterior']);
});

test('what takes away is never left out', () => {
  const {connection, socket} = connected();
  const lines = ['tint off', 'tint off', 'clip L off'];
  lines.forEach(line => void connection.set(command(line)));
  assert.deepEqual(linesOf(socket), lines);
});

test('the server\'s reason for closing is what the person reads', () => {
  mock.timers.enable({apis: ['setTimeout']});
  const {connection, socket} = connected();
  /** @type {string[]} */
  const told = [];
  connection.on('lost', why => told.push(why));
  socket.drop(1013, '8 viewers are connected already.');
  mock.timers.tick(250);
  HandSocket.all[1].drop(1009);
  assert.deepEqual(told, ['The server closed the connection: 8 viewers are connected already.',
    'The server closed the connection: a message was too long.']);
  mock.timers.reset();
});

/** A frame's message: header and no picture. @param {number} number */
function frameOf(number) {
  const message = new ArrayBuffer(FRAME_HEADER_BYTES);
  const view = new DataView(message);
  [0x46523550, number, number].forEach((value, k) => view.setUint32(4 * k, value, true));
  view.setUint8(16, 1);
  return message;
}

test('the frame of a lost connection is not acknowledged to the next', () => {
  mock.timers.enable({apis: ['setTimeout']});
  const {connection, socket} = connected();
  /** @type {(() => void)[]} */
  const acts = [];
  connection.on('frame', ({shown}) => acts.push(shown));
  socket.say(frameOf(7));
  socket.drop(1006);
  mock.timers.tick(250);
  const [, next] = HandSocket.all;
  next.accept();
  next.say(frameOf(1));
  acts.forEach(shown => shown());
  assert.deepEqual(next.sent.map(({shown}) => shown), [1]);
  mock.timers.reset();
});

/** The part of a browser's page that a picture needs; `decode` makes the bitmaps. */
function pictureIn(connection, decode) {
  const drawn = {count: 0};
  const element = {style: {}, width: 1, height: 1, getAttribute: () => '', setAttribute() {},
    getBoundingClientRect: () => ({width: 100, height: 100}), classList: {toggle() {}},
    getContext: () => ({canvas: element, drawImage: () => void ++drawn.count, clearRect() {}})};
  Object.assign(globalThis, {devicePixelRatio: 1, document: {getElementById: () => element},
    ResizeObserver: class { observe() {} }, createImageBitmap: decode,
    requestAnimationFrame: setImmediate});
  /** @type {string[]} */
  const told = [];
  const store = new Store();
  const picture = new PictureView(connection, store, text => told.push(text));
  return {picture, store, told, drawn};
}

/** Waits for the turns of a frame that is decoded at once. */
async function framesDone() {
  for (let turn = 0; turn < 4; ++turn) {
    await settled();
  }
}

test('a frame that fails is told and acknowledged, and the next one is shown', async () => {
  const {connection, socket} = connected();
  let decoded = 0;
  const {picture, told, drawn} = pictureIn(connection, async () => {
    if (++decoded === 1) {
      throw new Error('no JPEG');
    }
    return {width: 1, height: 1, close() {}};
  });
  picture.onShown(({number}) => {
    if (number === 2) {
      throw new Error('a listener fell');
    }
  });
  for (const number of [1, 2, 3]) {
    socket.say(frameOf(number));
    await framesDone();
  }
  assert.deepEqual(socket.sent.map(({shown}) => shown), [1, 2, 3]);
  assert.deepEqual(told, ['A picture could not be shown: no JPEG',
    'A picture could not be shown: a listener fell']);
  assert.equal(drawn.count, 2);
});

test('a frame of what is open no more is acknowledged, and not drawn', async () => {
  const {connection, socket} = connected();
  const {store, drawn} = pictureIn(connection, async () => ({width: 1, height: 1, close() {}}));
  socket.say(frameOf(1));
  store.take(/** @type {any} */ ({revision: 2, volume: null, archive: null}));
  await framesDone();
  for (const number of [2, 3]) {
    socket.say(frameOf(number));
    await framesDone();
  }
  assert.deepEqual(socket.sent.map(({shown}) => shown), [1, 2, 3]);
  assert.equal(drawn.count, 2);
});
