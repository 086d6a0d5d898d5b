// Which poses are asked for, and which pairs are shown, with a connection that the test answers.
import assert from 'node:assert/strict';
import test from 'node:test';
import { deflateRawSync } from 'node:zlib';
import { Pairs } from '../../../host/serve/page/headset/pairs.js';

const UNIT = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const WINDOW = { patient_to_eye: UNIT, projection: UNIT };
const EMPTY = deflateRawSync(Buffer.alloc(13));  // Depths of 4 x 4 pixels without a surface.

let now = 1000;
performance.now = () => now;
globalThis.createImageBitmap = async () => ({ width: 4, height: 8, close() {} });

/** Answers each message only when the test says so. */
function makePairs() {
  const acts = {}, sent = [], told = [], taken = [];
  const connection = { connected: true, hello: {},
                       on: (name, act) => { acts[name] = act; return () => {}; },
                       eyes: message => new Promise(answer => sent.push({ message, answer })) };
  const pairs = new Pairs(connection, { take: (bitmap, leans) => taken.push(leans.length) },
                          text => told.push(text));
  const ask = () => {
    pairs.ask([WINDOW, WINDOW], [4, 4], now);
    return sent.at(-1);
  };
  const reply = async (to, words) => {
    to.answer({ ok: true, ...words });
    await new Promise(setImmediate);
  };
  /** Waits until the frame is acknowledged. */
  const arrive = (pose, { revision = 1, depths = [EMPTY, EMPTY] } = {}) => new Promise(shown => {
    acts.frame({ header: { kind: 'jpeg', pose, revision, width: 4, height: 4, views: 2, layers: 1,
                           opacity: 16 },
                 depths, picture: new Uint8Array(), shown });
  });
  return { pairs, ask, reply, arrive, acts, sent, told, taken };
}


test('the next pose goes out when its pair has come, and not before', async () => {
  const { pairs, ask, reply, arrive, taken } = makePairs();
  assert.ok(pairs.isFree);
  const first = ask();
  assert.ok(!pairs.isFree);
  await reply(first);
  assert.ok(!pairs.isFree);
  await arrive(first.message.pose);
  assert.ok(pairs.isFree);
  assert.deepEqual([pairs.count, pairs.shown.pose], [1, first.message.pose]);
  assert.deepEqual(taken, [2]);
});

test('the next pose goes out after 10 s without a reply, or 1 s without a pair', async () => {
  const { pairs, ask, reply } = makePairs();
  const silent = ask();
  now += 9999;
  assert.ok(!pairs.isFree);
  now += 1;
  assert.ok(pairs.isFree);
  const answered = ask();
  await reply(silent);  // Too late: it says nothing about the pose under way.
  now += 1000;
  assert.ok(!pairs.isFree);
  await reply(answered);
  now += 999;
  assert.ok(!pairs.isFree);
  now += 1;
  assert.ok(pairs.isFree);
});

test('a superseded pose frees the way at once; a refusal is told, and waits for 2 s', async () => {
  const { pairs, ask, reply, told } = makePairs();
  await reply(ask(), { superseded: true });
  assert.ok(pairs.isFree && pairs.isKnown);
  await reply(ask(), { ok: false, error: 'no volume is open' });
  assert.deepEqual(told, ['no volume is open']);
  assert.ok(!pairs.isFree && !pairs.isKnown);
  now += 2000;
  assert.ok(pairs.isFree);
  await reply(ask());
  assert.equal(told.at(-1), '');
});

test('nothing goes back in time, and pairs of the former volume are dropped', async () => {
  const { pairs, ask, reply, arrive } = makePairs();
  const older = ask();
  await reply(older, { superseded: true });
  const newer = ask();
  await arrive(newer.message.pose, { revision: 7 });
  await arrive(older.message.pose, { revision: 7 });
  assert.equal(pairs.shown.pose, newer.message.pose);
  pairs.forget(9);
  assert.equal(pairs.shown, null);
  const former = ask();
  await arrive(former.message.pose, { revision: 8 });
  assert.equal(pairs.shown, null);
  const next = ask();
  await arrive(next.message.pose, { revision: 9 });
  assert.equal(pairs.shown.revision, 9);
  assert.ok(next.message.pose > former.message.pose);
});

test('a pair without its depths is told and acknowledged, and the next one is shown', async () => {
  const { pairs, ask, arrive, told } = makePairs();
  const broken = ask();
  await arrive(broken.message.pose, { depths: [EMPTY] });
  assert.match(told.at(-1), /has depths of 1 pictures, but 2 views of 1 layers need 2/);
  assert.equal(pairs.shown, null);
  const whole = ask();
  await arrive(whole.message.pose);
  assert.equal(pairs.shown.pose, whole.message.pose);
});

test('after a loss the next pose goes out at once, and revisions begin again', async () => {
  const { pairs, ask, arrive, acts } = makePairs();
  pairs.forget(50);
  ask();
  acts.lost();
  assert.ok(pairs.isFree && !pairs.isKnown);
  const again = ask();
  await arrive(again.message.pose, { revision: 1 });
  assert.equal(pairs.shown.revision, 1);
});
