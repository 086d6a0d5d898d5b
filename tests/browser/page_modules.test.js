// The page's modules that need no browser: turning, projection, messages, lines.
import assert from 'node:assert/strict';
import test from 'node:test';

import {anglesOf, drag, onBall, rotationOf, turn} from '../../host/serve/page/picture/arcball.js';
import {isoCommand, plain, roundIso, subjectOf, toLine, word}
  from '../../host/serve/page/link/lines.js';
import {parseAnswer, parseFrame} from '../../host/serve/page/link/messages.js';
import {camerasAt} from '../../host/serve/page/picture/camera.js';
import {deviceAxes, turnOfDevice} from '../../host/serve/page/picture/parallax.js';
import {lettersTowards, mmPerPlace, projectToPicture, roundLength}
  from '../../host/serve/page/picture/projection.js';
import {Refresh} from '../../host/serve/page/picture/refresh.js';
import {composedSize, partsOf} from '../../host/serve/page/picture/stereo.js';
import {wrapped} from '../../host/serve/page/elements/legend.js';
import {beyond} from '../../host/serve/page/slices/slice_words.js';
import {placeWarning} from '../../host/serve/page/panel/volume_words.js';
import {Selection} from '../../host/serve/page/state/selection.js';

/** @param {number[]} a @param {number[]} b */
function near(a, b, tolerance = 1e-9) {
  assert.equal(a.length, b.length);
  a.forEach((value, k) => assert.ok(Math.abs(value - b[k]) <= tolerance, `${a} is not ${b}`));
}

test('from in front, right is the patient\'s left, up is superior', () => {
  const rows = rotationOf({azimuth_deg: 0, elevation_deg: 0, roll_deg: 0});
  near(rows.flat(), [1, 0, 0, 0, 0, 1, 0, -1, 0]);
});

test('roll turns the picture counter-clockwise', () => {
  const [right, up] = rotationOf({azimuth_deg: 0, elevation_deg: 0, roll_deg: 90});
  // What was at the right is then above; what was above is at the left.
  near(up, [1, 0, 0]);
  near(right, [0, 0, -1]);
});

test('angles and rotation are each other\'s inverse', () => {
  for (const azimuth_deg of [0, 17, 90, 200, 359]) {
    for (const elevation_deg of [-80, -3, 0, 45, 89]) {
      for (const roll_deg of [-170, -20, 0, 60, 180]) {
        const angles = anglesOf(rotationOf({azimuth_deg, elevation_deg, roll_deg}));
        near(rotationOf(angles).flat(),
          rotationOf({azimuth_deg, elevation_deg, roll_deg}).flat(), 1e-9);
        near([angles.elevation_deg, Math.cos((angles.roll_deg - roll_deg) * Math.PI / 180)],
          [elevation_deg, 1], 1e-6);
      }
    }
  }
});

test('straight above, azimuth takes the roll over', () => {
  const wanted = rotationOf({azimuth_deg: 180, elevation_deg: 90, roll_deg: 30});
  const angles = anglesOf(wanted);
  assert.equal(angles.roll_deg, 0);
  near(rotationOf(angles).flat(), wanted.flat(), 1e-6);
});

test('a drag carries the point under it, and turns twice the angle between', () => {
  const start = rotationOf({azimuth_deg: 0, elevation_deg: 0, roll_deg: 0});
  // To the right by 30 degrees on the ball: what faced the viewer goes 60 degrees to the right.
  const [right, , back] = drag(start, onBall(0, 0), onBall(Math.sin(Math.PI / 6), 0));
  const front = [0, -1, 0];
  const seen = (/** @type {number[]} */ row) => row.reduce((sum, v, k) => sum + v * front[k], 0);
  near([seen(right), seen(back)], [Math.sin(Math.PI / 3), Math.cos(Math.PI / 3)]);
});

test('a thousand turns leave the axes square', () => {
  let rows = rotationOf({azimuth_deg: 10, elevation_deg: 20, roll_deg: 30});
  for (let k = 0; k < 1000; ++k) {
    rows = turn(rows, [0.6, 0.8, 0], 0.1);
  }
  const dot = (/** @type {number[]} */ a, /** @type {number[]} */ b) =>
    a.reduce((sum, v, k) => sum + v * b[k], 0);
  near([dot(rows[0], rows[1]), dot(rows[1], rows[2]), dot(rows[0], rows[0])], [0, 0, 1]);
});

test('a drag that returns leaves the view as it was, outside of the ball too', () => {
  const start = rotationOf({azimuth_deg: 33, elevation_deg: -12, roll_deg: 5});
  const a = onBall(0.9, 0.8), b = onBall(-2, 1);
  near(drag(drag(start, a, b), b, a).flat(), start.flat());
});

test('letters name the sides that the picture\'s edges are towards', () => {
  const eye = (/** @type {number[][]} */ [r, u, b]) =>
    [r[0], u[0], b[0], 0, r[1], u[1], b[1], 0, r[2], u[2], b[2], 0, 0, 0, 0, 1];
  const front = eye(rotationOf({azimuth_deg: 0, elevation_deg: 0, roll_deg: 0}));
  assert.deepEqual([[1, 0], [-1, 0], [0, 1], [0, -1]].map(on =>
    lettersTowards(front, /** @type {[number, number]} */ (on))), ['L', 'R', 'S', 'I']);
  const oblique = eye(rotationOf({azimuth_deg: 30, elevation_deg: 0, roll_deg: 0}));
  assert.equal(lettersTowards(oblique, [1, 0]), 'LP');
});

test('the middle projects to the middle; a place is as long as mmPerPlace says', () => {
  // Looks along -z from 1000 mm, magnified 4 times, in a picture of 400 x 200 places.
  const eye = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1000, 1];
  const clip = [2, 0, 0, 0, 0, 4, 0, 0, 0, 0, -1, -1, 0, 0, 0, 1000];
  const middle = projectToPicture(clip, [0, 0, 0], 400, 200);
  near([middle.x, middle.y], [200, 100]);
  const mm = mmPerPlace(eye, clip, 200, [0, 0, 0]);
  const above = projectToPicture(clip, [0, 10 * mm, 0], 400, 200);
  near([above.x, above.y], [200, 90]);
  assert.equal(projectToPicture(clip, [0, 0, 2000], 400, 200).visible, false);
});

test('scale bars have round lengths', () => {
  assert.deepEqual([99, 100, 49, 5.1, 0.19].map(roundLength), [50, 100, 20, 5, 0.1]);
});

test('a frame\'s header is taken apart; what is cut off is refused', () => {
  const view = new DataView(new ArrayBuffer(56 + 3 + 11));
  view.setUint32(0, 0x46523550, true);
  [7, 300].forEach((value, k) => view.setUint32(4 + 4 * k, value, true));
  [640, 480].forEach((value, k) => view.setUint16(12 + 2 * k, value, true));
  [2, 90, 16, 3].forEach((value, k) => view.setUint8(16 + k, value));
  view.setFloat32(20, 12.5, true);
  view.setBigUint64(24, 0xabcdef0123456789n, true);
  view.setFloat64(32, 0.75, true);
  [3, 11, 9].forEach((value, k) => view.setUint32(40 + 4 * k, value, true));
  [2, 1, 6].forEach((value, k) => view.setUint8(52 + k, value));
  [1, 2, 3, 2, 0, 0, 0, 4, 5, 1, 0, 0, 0, 6].forEach((value, k) => view.setUint8(56 + k, value));
  const {header, picture, depths} = parseFrame(view.buffer);
  assert.deepEqual(header, {number: 7, revision: 300, width: 640, height: 480, kind: 'png',
    quality: 90, samples: 16, rests: true, last: true, key: false, fullColor: false,
    machine_ms: 12.5, digest: 'abcdef0123456789', moved_mm: 0.75, pose: 9, views: 2, layers: 1,
    opacity: 6, reserved: 0});
  assert.deepEqual([picture, ...depths].map(each => [...each]), [[1, 2, 3], [4, 5], [6]]);
  assert.throws(() => parseFrame(new ArrayBuffer(55)), /55 bytes, its header has 56/);
  assert.throws(() => parseFrame(view.buffer.slice(0, 69)), /69 bytes, .* end at 70/);
  view.setUint8(65, 2);
  assert.throws(() => parseFrame(view.buffer), /picture 2 end at byte 71, but the frame has 70/);
  view.setUint8(65, 0);  // A third picture, of which one byte is left.
  assert.throws(() => parseFrame(view.buffer), /picture 3 end at byte 73, but the frame has 70/);
  view.setUint8(65, 1);
  view.setUint8(16, 9);
  assert.throws(() => parseFrame(view.buffer), /kind 9/);
  view.setUint8(16, 3);
  view.setUint8(19, 8);
  const {kind, key, rests} = parseFrame(view.buffer).header;
  assert.deepEqual({kind, key, rests}, {kind: 'vp8', key: true, rests: false});
});

test('an answer\'s bytes begin at a multiple of 8', () => {
  const json = new TextEncoder().encode('{"width":3}');
  const message = new Uint8Array(16 + 16 + 4);
  new DataView(message.buffer).setUint32(4, 42, true);
  new DataView(message.buffer).setUint32(8, json.length, true);
  message.set(json, 16);
  message.set([1, 2, 3, 4], 32);
  const answer = parseAnswer(message.buffer);
  assert.equal(answer.id, 42);
  assert.deepEqual(answer.json, {width: 3});
  assert.deepEqual([...new Uint8Array(answer.bytes)], [1, 2, 3, 4]);
  new DataView(message.buffer).setUint32(8, 999, true);
  assert.throws(() => parseAnswer(message.buffer), /36 bytes, its JSON ends at 1015/);
});

test('words are quoted as the command line takes them', () => {
  assert.equal(word('bone'), 'bone');
  assert.equal(word('left knee'), '"left knee"');
  assert.equal(word('a=b'), '"a=b"');
  assert.equal(word('say "hi"'), '"say "\'"\'"hi"\'"\'');
  assert.equal(word(''), '""');
});

const TABLE = /** @type {any[]} */ ([
  {name: 'surface', kind: 'setting', subject_words: 1},
  {name: 'light', kind: 'setting', subject_words: 1},
  {name: 'clip', kind: 'setting', subject_words: 1},
  {name: 'view', kind: 'setting', subject_words: 0},
  {name: 'components', kind: 'setting', subject_words: 1},
  {name: 'orbit', kind: 'action', subject_words: 0},
]);

test('a command becomes a line with quotes where they are needed', () => {
  assert.equal(toLine({name: 'surface', words: ['left knee'], options: {iso: 1, color: '#ffffff'}}),
    'surface "left knee" iso=1 color="#ffffff"');
  assert.equal(toLine({name: 'undo'}), 'undo');
});

test('two commands have one subject if the later replaces the earlier', () => {
  const subject = (/** @type {string} */ name, words = /** @type {any[]} */ ([]), options = {}) =>
    subjectOf({name, words, options}, TABLE);
  assert.equal(subject('surface', ['bone'], {iso: 1}), subject('surface', ['bone'], {iso: 2}));
  assert.equal(subject('view', [1, 2], {zoom: 1, roll: 0}),
    subject('view', [3, 4], {roll: 9, zoom: 2}));
  assert.notEqual(subject('surface', ['bone'], {iso: 1}), subject('surface', ['skin'], {iso: 1}));
  assert.notEqual(subject('surface', ['bone'], {iso: 1}), subject('surface', ['bone'], {color: 1}));
  assert.notEqual(subject('light', [1, 0, 0]), subject('light', [2, 0, 0]));
  assert.notEqual(subject('clip', ['L', 5]), subject('clip', ['A', 5]));
  assert.notEqual(subject('surface', ['a b'], {iso: 1}), subject('surface', ['a c'], {iso: 1}));
  assert.notEqual(subject('surface', ['iso=1']), subject('surface', ['a'], {iso: 1}));
  assert.notEqual(subject('view', [1, 2]), subject('view', ['anterior']));
  assert.equal(subject('undo'), '');
  assert.equal(subject('clip', ['L', 'off']), '');
  assert.equal(subject('components', ['bone'], {at: '1,2'}), '');
  assert.equal(subject('orbit', ['a']), '');
});

test('a command that only the server knows is a setting of the page, too', () => {
  const planted = {name: 'haze', words: [0.5]};
  assert.equal(subjectOf(planted, TABLE), '');
  const table = [...TABLE, {name: 'haze', kind: 'setting', subject_words: 0}];
  assert.equal(subjectOf(planted, table), subjectOf({...planted, words: [0.7]}, table));
  assert.notEqual(subjectOf(planted, table), '');
});

test('isovalues of whole numbers lie between two; of others they have few digits', () => {
  assert.equal(roundIso(99.2, {minimum: -1000, maximum: 3000}), 99.5);
  assert.equal(roundIso(-0.2, {minimum: -1000, maximum: 3000}), -0.5);
  assert.equal(roundIso(0.123456, {minimum: 0, maximum: 1}), 0.123);
  assert.equal(toLine(isoCommand('bone', 1e-7)), 'surface bone iso=0.0000001');
  assert.deepEqual([plain(100), plain(-0.001), plain(1.5), plain(20, 0)],
    ['100', '0', '1.5', '20']);
});

test('a long line of a legend wraps between words, and loses none', () => {
  const widthOf = text => text.length;
  assert.deepEqual(wrapped('place or spacing ASSUMED', widthOf, 30), ['place or spacing ASSUMED']);
  assert.deepEqual(wrapped('place or spacing ASSUMED', widthOf, 16),
    ['place or spacing', 'ASSUMED']);
  assert.deepEqual(wrapped('place or spacing ASSUMED', widthOf, 3),
    ['place', 'or', 'spacing', 'ASSUMED']);
});

test('a volume with an assumption has a warning, others have none', () => {
  const volume = kinds => ({findings: kinds.map(kind => ({kind, text: ''}))});
  assert.equal(placeWarning(null), '');
  assert.equal(placeWarning(volume(['note', 'gantry tilt'])), '');
  assert.equal(placeWarning(volume(['note', 'assumption'])), 'place or spacing ASSUMED');
});

test('slices name what they show and the picture hides', () => {
  const surface = (name, components, visible = true, compared_with = '') =>
    ({name, components, visible, compared_with});
  const clips = [{words: 'L 20', plane: []}];
  assert.equal(beyond({surfaces: [surface('skin', 'all')], clips: []}), '');
  assert.equal(beyond({surfaces: [surface('skin', 'all')], clips}),
    'Not in the 3D picture: parts behind clip planes.');
  const surfaces = [surface('bone', 'largest'), surface('fat', 'min_ml=1'),
    surface('hidden', 'largest', false), surface('other', 'largest', true, 'bone')];
  assert.equal(beyond({surfaces, clips: []}),
    'Not in the 3D picture: components of bone, fat.');
  assert.equal(beyond({surfaces, clips}),
    'Not in the 3D picture: parts behind clip planes and components of bone, fat.');
  assert.equal(beyond({surfaces: [], clips}), '', 'the picture is empty');
});

test('a watcher of the selection ends, so that what it refers to can go', () => {
  const selection = new Selection(), heard = [];
  const end = selection.watch(name => heard.push(name));
  selection.choose('bone');
  end();
  selection.choose('skin');
  assert.deepEqual(heard, ['', 'bone']);
});

test('the axes of a device that lies flat, stands up, and has turned', () => {
  near(deviceAxes({alpha: 0, beta: 0, gamma: 0}).flat(), [1, 0, 0, 0, 1, 0, 0, 0, 1]);
  near(deviceAxes({alpha: 0, beta: 90, gamma: 0}).flat(), [1, 0, 0, 0, 0, 1, 0, -1, 0]);
  near(deviceAxes({alpha: 90, beta: 0, gamma: 0}).flat(), [0, 1, 0, -1, 0, 0, 0, 0, 1]);
  near(deviceAxes({alpha: 0, beta: 0, gamma: 90}).flat(), [0, 0, -1, 0, 1, 0, 1, 0, 0]);
});

test('a device that turns its screen to the left shows the view from the right', () => {
  const turned = (before, now, angle) => {
    const {right, up} = turnOfDevice(deviceAxes(before), deviceAxes(now), angle);
    return [right, up];
  };
  const upright = {alpha: 0, beta: 90, gamma: 0};
  near(turned(upright, upright, 0), [0, 0]);
  // About the vertical axis, counter-clockwise from above: the screen, which faces the viewer in
  // the south, then faces the east, at the viewer's right. The viewer is at its left.
  near(turned(upright, {...upright, alpha: 10}, 0), [-10, 0]);
  near(turned(upright, {...upright, alpha: -10}, 0), [10, 0]);
  // Tilted back, the screen faces upwards. The viewer is below.
  near(turned(upright, {...upright, beta: 80}, 0), [0, -10]);
  const flat = {alpha: 30, beta: 0, gamma: 0};
  near(turned(flat, {...flat, gamma: 10}, 0), [-10, 0]);
  // In the hand turned counter-clockwise by 90 degrees, the device's right is the page's top.
  near(turned(flat, {...flat, gamma: 10}, 90), [0, -10]);
  near(turned(flat, {...flat, beta: 10}, 90), [-10, 0]);
  near(turned(flat, {...flat, gamma: 10}, 270), [0, 10]);
});

test('the parts of a stereo picture, and its size', () => {
  assert.deepEqual(partsOf('off'), [{eyes: [0], left: 0, width: 1}]);
  assert.deepEqual(partsOf('rows'), [{eyes: [0, 1], left: 0, width: 1}]);
  assert.deepEqual(partsOf('sbs').map(({eyes, left}) => [...eyes, left]), [[0, 0], [1, 0.5]]);
  assert.deepEqual(partsOf('cross').map(({eyes, left}) => [...eyes, left]), [[1, 0], [0, 0.5]]);
  assert.deepEqual(composedSize([30, 20], 'cross'), [60, 20]);
  assert.deepEqual(composedSize([30, 20], 'anaglyph'), [30, 20]);
});

test('the eyes are apart along the rows, and see the plane of convergence at one place', () => {
  const view = {azimuth_deg: 20, elevation_deg: 10, roll_deg: 30, zoom: 1.5, pan_mm: [4, -3]};
  const subject = {center_mm: [1, 2, 3], radius_mm: 100};
  const cameras = camerasAt(view, subject, 1.2,
    {mode: 'sbs', separation_mm: 30, convergence_mm: 250});
  const [left, right] = cameras.map(each => each.patient_to_eye);
  near(left.map((value, k) => value - right[k]), [...Array(12).fill(0), 30, 0, 0, 0], 1e-9);
  // A point that the camera between them has 250 mm away.
  const [x, y, z] = [12, -7, -250].map((mm, k) => mm - (left[12 + k] + right[12 + k]) / 2);
  const at = [0, 1, 2].map(k => left[4 * k] * x + left[4 * k + 1] * y + left[4 * k + 2] * z);
  const [a, b] = cameras.map(each => projectToPicture(each.patient_to_clip, at, 500, 400));
  near([a.x, a.y], [b.x, b.y], 1e-9);
});

/** Runs with refreshes of the screen that the test makes. */
async function withScreen(act) {
  const waiting = [];
  globalThis.requestAnimationFrame = wake => waiting.push(wake);
  const task = () => new Promise(resolve => setTimeout(resolve));
  try {
    await act({ begin: () => waiting.splice(0).forEach(wake => wake(0)), task });
  } finally {
    delete globalThis.requestAnimationFrame;
  }
}

test('the screen shows each picture that has room, and the first at once', () =>
  withScreen(async ({ begin, task }) => {
    const refresh = new Refresh(), drawn = [];
    const draw = name => refresh.room().then(() => drawn.push(name));
    void draw('a');
    await task();
    assert.deepEqual(drawn, ['a']);
    void draw('b');
    await task();
    assert.deepEqual(drawn, ['a'], 'the screen does not show a yet');
    begin();
    for (let i = 0; i < 20; i++) await Promise.resolve();  // All that follows before the screen.
    assert.deepEqual(drawn, ['a'], 'b would replace a in this refresh');
    await task();
    await task();
    assert.deepEqual(drawn, ['a', 'b']);
    begin();
    await task();
    await task();
    void draw('c');
    await task();
    assert.deepEqual(drawn, ['a', 'b', 'c'], 'the screen shows b');
  }));

test('a headset ends all waits for the screen, which may have no refresh then', () =>
  withScreen(async ({ task }) => {
    const refresh = new Refresh(), done = [];
    await refresh.room();
    await task();
    void refresh.next().then(() => done.push('next'));
    void refresh.room().then(() => done.push('room'));
    await task();
    assert.deepEqual(done, []);
    refresh.isWorn = true;
    await task();
    await task();
    assert.deepEqual(done, ['next', 'room']);
    await refresh.room();
    await refresh.next();
  }));

test('a JPEG that WebCodecs does not decode is read as a blob, and so are later ones', async () => {
  const asked = [];
  globalThis.ImageDecoder = class {
    decode() {
      asked.push('decoder');
      return Promise.reject(new Error('no'));
    }
    close() { asked.push('closed'); }
  };
  globalThis.createImageBitmap = async source => {
    asked.push(source.type);
    return source;
  };
  try {
    const {bitmapOfFile} =
      await import('../../host/serve/page/picture/bitmaps.js?with=decoder');
    const picture = new Uint8Array([1]);
    for (const kind of ['png', 'jpeg', 'jpeg']) await bitmapOfFile({ header: { kind }, picture });
    assert.deepEqual(asked, ['image/png', 'decoder', 'closed', 'image/jpeg', 'image/jpeg']);
  } finally {
    delete globalThis.ImageDecoder;
    delete globalThis.createImageBitmap;
  }
});
