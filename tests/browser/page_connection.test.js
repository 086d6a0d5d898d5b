// The page's side of the protocol, against a socket that the test holds in its hand.
import assert from 'node:assert/strict';
import test, {mock} from 'node:test';

import {Connection} from '../../host/serve/page/connection.js';

/** What the browser's WebSocket does, as far as the page uses it. */
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
    this.say({hello: {version: '1', role: 'driver', viewer: 1, topology: 'default'}});
  }

  /** @param {object | ArrayBuffer} what */
  say(what) {
    this.onmessage({data: what instanceof ArrayBuffer ? what : JSON.stringify(what)});
  }

  /** @param {number} code */
  drop(code) {
    this.readyState = 3;
    this.onclose({code});
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
  const replies = Array.from({length: 100}, (_, k) => connection.set(`surface bone iso=${k}`));
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
  void connection.set('surface bone iso=5');
  await settled();
  assert.equal(socket.sent.length, 3);
});

test('settings of different things do not wait for each other', () => {
  const {connection, socket} = connected();
  void connection.set('surface bone iso=1');
  void connection.set('surface skin iso=1');
  void connection.set('view 1 2');
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

test('a lost connection answers everybody, comes back, and wants the same', async () => {
  mock.timers.enable({apis: ['setTimeout']});
  const {connection, socket} = connected();
  connection.wantMachine(true);
  const reply = connection.do('load phantom:pelvis', {quiet: true});
  const drag = connection.set('view 1 2'), newest = connection.set('view 3 4');
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
