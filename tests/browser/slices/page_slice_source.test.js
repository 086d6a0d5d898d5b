// Where slices come from: the newest first, kept ones without a request, packed on a slow link.
import assert from 'node:assert/strict';
import test from 'node:test';
import {deflateSync} from 'node:zlib';

import {unpacked} from '../../../host/serve/page/slices/slice_packing.js';
import {SliceSource} from '../../../host/serve/page/slices/slice_source.js';

const SIDE = 64, LARGE = 512;

/** An answer to a question about a slice, whose values are all its index. It is not packed. */
function answerTo({index = 0}, side) {
  const values = new Int16Array(side * side).fill(index);
  return {json: {width: side, height: side, type: 'int16', contours: []}, bytes: values.buffer};
}

/** Values as the server packs them. */
function packedOf(values) {
  const each = values.BYTES_PER_ELEMENT, count = values.length;
  const words = new DataView(values.buffer, values.byteOffset);
  const read = {1: k => BigInt(words.getUint8(k)), 2: k => BigInt(words.getUint16(2 * k, true)),
    4: k => BigInt(words.getUint32(4 * k, true))}[each];
  const planes = new Uint8Array(count * each);
  for (let k = 0; k < count; ++k) {
    const difference = BigInt.asUintN(8 * each, read(k) - (k > 0 ? read(k - 1) : 0n));
    for (let plane = 0; plane < each; ++plane) {
      planes[plane * count + k] = Number(difference >> BigInt(8 * plane) & 255n);
    }
  }
  const bytes = deflateSync(planes);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
}

/** A source whose answers the test gives, with what it asked and showed. */
function held(t, {ms, side = SIDE}) {
  let now = 0;
  t.mock.method(performance, 'now', () => now);
  const asked = [], shown = [], failures = [];
  const source = new SliceSource({ask: question =>
    new Promise((answer, reject) => asked.push({question, answer, reject}))},
  {slice: ({values, index}) => {
    assert.ok(values.every(value => value === index), `the values of slice ${index}`);
    shown.push(index);
  }, failed: sentence => failures.push(sentence)});
  const settle = () => new Promise(done => setImmediate(done));
  let answered = 0;
  const waiting = () => asked[answered++];  // Answers come in the order of the questions.
  return {source, shown, failures,
    want: (index, of = 'a') => source.want({axis: 'z', index, count: 20}, of),
    questions: () => asked.map(({question}) => question.index),
    last: () => asked.at(-1).question,
    async refuse() {
      waiting().reject(new Error('refused'));
      await settle();
    },
    async give(took = ms) {
      const {question, answer} = waiting();
      now += took;
      answer(answerTo(question, side));
      await settle();  // Promises alone follow, which are all done before.
    }};
}

test('values of every type are unpacked bit for bit', async () => {
  const of = {uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array, float32: Float32Array};
  for (const [type, array] of Object.entries(of)) {
    const values = array.from({length: 15}, (_, k) => 1000 * Math.sin(k * k));
    const {bytes} = await unpacked({bytes: packedOf(values), json: {width: 5, height: 3, type,
      packed: {bytes: values.byteLength}}});
    assert.deepEqual(new array(bytes), values, type);
  }
});

test('packed bytes that are not as many as the description says are refused', async () => {
  const json = {width: 5, height: 3, type: 'uint8', packed: {bytes: 16}};
  await assert.rejects(unpacked({bytes: packedOf(new Uint8Array(15)), json}),
                       /15 bytes were packed, its description says 16/);
  json.packed.bytes = 14;
  await assert.rejects(unpacked({bytes: packedOf(new Uint8Array(14)), json}),
                       /14 bytes were packed, 5 x 3 values of uint8 have 15/);
});

test('a slice that was shown is shown again without a request', async t => {
  const {want, give, shown, questions} = held(t, {ms: 1});
  want(3);
  await give();
  want(9);
  await give();
  want(3);
  assert.deepEqual(shown, [3, 9, 3]);
  assert.deepEqual(questions(), [3, 9]);
  want(3, 'other contours');
  assert.deepEqual(questions(), [3, 9, 3]);
});

test('a late answer does not replace a kept slice that was asked for after it', async t => {
  const {want, give, shown} = held(t, {ms: 1});
  want(3);
  await give();
  want(9);
  want(3);
  assert.deepEqual(shown, [3, 3]);
  await give();
  assert.deepEqual(shown, [3, 3]);
});

test('an error is not told over a slice that was asked for after it', async t => {
  const {want, give, refuse, failures} = held(t, {ms: 1});
  want(3);
  await give();
  want(9);
  want(3);
  await refuse();
  assert.deepEqual(failures, []);
  want(9);
  await refuse();
  assert.deepEqual(failures, ['refused']);
});

test('on a slow link slices are packed, and the next in the direction comes with them', async t => {
  const {want, give, shown, questions, last} = held(t, {ms: 300});
  want(5);
  assert.equal(last().packed, true, 'the first one, as nothing is known of the link');
  await give();
  assert.deepEqual(questions(), [5], 'no step, nothing ahead');
  want(6);
  assert.deepEqual(questions(), [5, 6, 7], 'before 6 is there');
  assert.equal(last().packed, true);
  assert.equal(last().ahead, true);
  await give();
  await give();
  assert.deepEqual(shown, [5, 6], 'what came ahead is not shown');
  want(7);
  assert.deepEqual(shown, [5, 6, 7], 'at once');
  assert.deepEqual(questions(), [5, 6, 7, 8]);
  want(8);
  assert.deepEqual(questions(), [5, 6, 7, 8, 9], '8 is under way, and is not asked for twice');
  await give();
  assert.deepEqual(shown, [5, 6, 7, 8]);
});

test('a slice ahead that is refused is neither told nor asked for again', async t => {
  const {want, give, refuse, questions, failures} = held(t, {ms: 300});
  want(5);
  await give();
  want(6);
  await give();
  await refuse();
  assert.deepEqual(questions(), [5, 6, 7]);
  assert.deepEqual(failures, []);
  want(7);
  assert.deepEqual(questions(), [5, 6, 7, 7, 8]);
  await refuse();
  assert.deepEqual(failures, ['refused']);
});

test('a slice that was refused when it came ahead is asked for again if wanted', async t => {
  const {want, give, refuse, questions, failures, shown} = held(t, {ms: 300});
  want(5);
  await give();
  want(6);
  await give();
  want(7);  // Under way.
  assert.deepEqual(questions(), [5, 6, 7, 8]);
  await refuse();  // The server has only the newest of those ahead.
  assert.deepEqual(questions(), [5, 6, 7, 8, 7]);
  await give();
  await give();
  assert.deepEqual([failures, shown], [[], [5, 6, 7]]);
});

test('the time of an answer that waited for the one before is that of its own', async t => {
  const {want, give, last} = held(t, {ms: 30});
  want(5);
  await give(50);
  want(6);
  assert.equal(last().ahead, true, 'a slow link');
  await give();
  await give();  // 60 ms after its question.
  want(8);
  assert.equal(last().packed, undefined, 'a fast link');
});

test('nothing comes ahead beyond the ends and after jumps', async t => {
  const {want, give, questions} = held(t, {ms: 300});
  for (const index of [18, 19, 4]) {
    want(index);
    await give();
  }
  assert.deepEqual(questions(), [18, 19, 4]);
});

test('on a fast link nothing is packed and nothing comes ahead', async t => {
  const {want, give, questions, last} = held(t, {ms: 1});
  for (const index of [5, 6, 7]) {
    want(index);
    await give();
  }
  assert.deepEqual(questions(), [5, 6, 7]);
  assert.equal(last().packed, undefined);
});

test('another volume drops what was kept', async t => {
  const {source, want, give, questions} = held(t, {ms: 1});
  want(3);
  await give();
  source.forget();
  want(3);
  assert.deepEqual(questions(), [3, 3]);
});

test('values beyond 24 MiB are dropped, the oldest first', async t => {
  const {want, give, questions} = held(t, {ms: 1, side: LARGE});
  const fit = 24 * 2 ** 20 / (2 * LARGE * LARGE);
  for (let index = 0; index <= fit; ++index) {
    want(index);
    await give();
  }
  const before = questions().length;
  want(1);
  want(fit);
  assert.equal(questions().length, before, 'kept');
  want(0);
  assert.equal(questions().length, before + 1, 'dropped');
});
