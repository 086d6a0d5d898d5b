// How the page decodes video, with a decoder that the test holds in its hand.
import assert from 'node:assert/strict';
import test, {mock} from 'node:test';

import {PictureView} from '../../../host/serve/page/picture/picture.js';
import {Video} from '../../../host/serve/page/picture/video.js';
import {Store} from '../../../host/serve/page/state/store.js';

/** The part of the browser's decoder that the page uses. */
class HandDecoder {
  /** @type {HandDecoder[]} */
  static all = [];
  static supported = true;
  static isConfigSupported = async () => ({supported: HandDecoder.supported});

  /** @param {{output: (picture: any) => void, error: (error: Error) => void}} acts */
  constructor(acts) {
    Object.assign(this, acts);
    this.state = 'unconfigured';
    /** @type {any[]} */
    this.chunks = [];
    HandDecoder.all.push(this);
  }

  configure() {
    this.state = 'configured';
  }

  /** @param {any} chunk */
  decode(chunk) {
    if (chunk.data[0] === 0) {
      throw new Error('not a picture');
    }
    this.chunks.push(chunk);
  }

  close() {
    this.state = 'closed';
  }

  /** The decoder has decoded the oldest chunk. */
  give() {
    const {timestamp, data} = this.chunks.shift();
    const picture = {timestamp, shows: data[0], isClosed: false,
      close() { picture.isClosed = true; }};
    this.output(picture);
    return picture;
  }
}
Object.assign(globalThis, {VideoDecoder: HandDecoder, location: {href: 'http://localhost/'},
  EncodedVideoChunk: class {
    constructor(/** @type {any} */ init) { Object.assign(this, init); }
  }});

/** Promises that are settled have acted. */
const settled = () => new Promise(resolve => setImmediate(resolve));

/** A connection that keeps what the page asks for. */
function connected() {
  HandDecoder.all = [];
  HandDecoder.supported = true;
  /** @type {Map<string, ((what: any) => void)[]>} */
  const acts = new Map();
  const asked = /** @type {boolean[]} */ ([]);
  const connection = {asked,
    on: (/** @type {string} */ name, /** @type {() => void} */ act) =>
      acts.set(name, [...acts.get(name) ?? [], act]),
    wantVideo: (/** @type {boolean} */ wanted) => asked.push(wanted),
    say: (/** @type {string} */ name, /** @type {any} */ what) =>
      acts.get(name)?.forEach(act => act(what))};
  const told = /** @type {string[]} */ ([]);
  const video = new Video(/** @type {any} */ (connection), text => told.push(text));
  connection.say('hello', {});
  return {connection, video, told, asked};
}

/** A video frame that shows a number; 0 breaks the decoder. */
function frameOf(/** @type {number} */ shows, {key = false, shown = () => {}} = {}) {
  return /** @type {any} */ ({header: {kind: 'vp8', key, revision: shows, number: shows},
    picture: new Uint8Array([shows]), depths: new Uint8Array(), shown});
}

test('the page asks for video if the browser can decode it', async () => {
  const {connection, asked} = connected();
  await settled();
  HandDecoder.supported = false;
  connection.say('hello', {});
  await settled();
  assert.deepEqual(asked, [true, false]);
});

test('frames are decoded in order; nothing is decoded before a key frame', async () => {
  const {video} = connected();
  assert.equal(await video.decode(frameOf(1)), null);
  const pictures = [2, 3, 4].map(shows => video.decode(frameOf(shows, {key: shows === 2})));
  const [decoder] = HandDecoder.all;
  assert.deepEqual(decoder.chunks.map(({type, data}) => [type, data[0]]),
    [['key', 2], ['delta', 3], ['delta', 4]]);
  pictures.forEach(() => decoder.give());
  assert.deepEqual((await Promise.all(pictures)).map((/** @type {any} */ each) => each.shows),
    [2, 3, 4]);
  assert.equal(video.figures.decoded, 3);
});

test('after an error the page asks for a new video and waits for its key frame', async () => {
  const {video, asked, told} = connected();
  await settled();
  const first = video.decode(frameOf(1, {key: true})), second = video.decode(frameOf(2));
  HandDecoder.all[0].error(new Error('broken'));
  assert.deepEqual(await Promise.all([first, second]), [null, null]);
  await settled();
  assert.deepEqual(asked, [true, true]);
  assert.equal(await video.decode(frameOf(3)), null);
  const next = video.decode(frameOf(4, {key: true}));
  HandDecoder.all[1].give();
  assert.equal(/** @type {any} */ (await next).shows, 4);
  assert.deepEqual(told, []);
});

test('after three errors in a row the page wants no video, and says why once', async () => {
  const {connection, video, asked, told} = connected();
  for (let i = 0; i < 3; ++i) {
    assert.equal(await video.decode(frameOf(0, {key: true})), null);
  }
  await settled();
  assert.equal(asked.at(-1), false);
  assert.equal(told.length, 1);
  assert.match(told[0], /cannot decode .*not a picture.* JPEG/);
  connection.say('hello', {});
  await settled();
  assert.equal(asked.at(-1), false);
});

test('a decoder that is silent has failed', async () => {
  mock.timers.enable({apis: ['setTimeout']});
  const {video} = connected();
  const picture = video.decode(frameOf(1, {key: true}));
  mock.timers.tick(3000);
  assert.equal(await picture, null);
  assert.equal(video.figures.failures, 1);
  mock.timers.reset();
});

test('a lost connection ends the video without an error', async () => {
  const {connection, video} = connected();
  const picture = video.decode(frameOf(1, {key: true}));
  connection.say('lost', '');
  assert.equal(await picture, null);
  assert.equal(HandDecoder.all[0].state, 'closed');
  assert.equal(video.figures.failures, 0);
});

test('only the newest frame is shown, but each is decoded, and acknowledged after that',
     async () => {
  const {connection, video} = connected();
  const drawn = /** @type {number[]} */ ([]), acknowledged = /** @type {number[]} */ ([]);
  const element = {style: {}, width: 1, height: 1, getAttribute: () => '', setAttribute() {},
    getBoundingClientRect: () => ({width: 100, height: 100}), getContext: () => ({canvas: element,
      drawImage: (/** @type {any} */ bitmap) => drawn.push(bitmap.shows), clearRect() {}})};
  Object.assign(globalThis, {devicePixelRatio: 1, document: {getElementById: () => element},
    ResizeObserver: class { observe() {} }, requestAnimationFrame: setImmediate,
    createImageBitmap: async (/** @type {any} */ {shows}) =>
      ({shows, width: 1, height: 1, close() {}})});
  const picture = new PictureView(/** @type {any} */ (connection), new Store(), assert.fail);
  picture.video = video;
  for (const shows of [1, 2, 3, 4]) {
    connection.say('frame', frameOf(shows, {key: shows === 1,
      shown: () => acknowledged.push(shows)}));
  }
  await settled();
  const [decoder] = HandDecoder.all;
  assert.equal(decoder.chunks.length, 4);
  assert.deepEqual(acknowledged, []);
  const pictures = [1, 2, 3, 4].map(() => decoder.give());
  for (let turn = 0; turn < 8; ++turn) {
    await settled();
  }
  assert.deepEqual(drawn, [1, 4]);
  assert.deepEqual([...acknowledged].sort(), [1, 2, 3, 4]);
  assert.ok(pictures.every(each => each.isClosed));
});
