// The headset's geometry, without a browser: rotations, the patient's place, windows, prediction.
import assert from 'node:assert/strict';
import test from 'node:test';
import { multiply } from '../../../host/serve/page/picture/camera.js';
import { transform } from '../../../host/serve/page/picture/projection.js';
import { Placement } from '../../../host/serve/page/headset/placement.js';
import { HeadTrack } from '../../../host/serve/page/headset/prediction.js';
import { compose, inverted, length, matrixOf, minus, rotated, slerp, turnAbout, turnBetween, unit }
  from '../../../host/serve/page/headset/rigid.js';
import { isLight, roomOf, sizeText } from '../../../host/serve/page/headset/room.js';
import { sizeOf, windowsOf } from '../../../host/serve/page/headset/windows.js';

const SPHERE = { center_mm: [12, -30, 400], radius_mm: 250 };
const UP = [0, 1, 0];
let seed = Number(process.env.PXPL5_SEED ?? '1993');

function next(least, most) {
  seed = (seed * 1103515245 + 12345) % 2147483648;
  return least + (most - least) * seed / 2147483648;
}
const vector = size => [next(-size, size), next(-size, size), next(-size, size)];
const pose = () => ({ position: vector(2), turn: turnAbout(unit(vector(1)), next(-3, 3)) });
const near = (a, b, tolerance, what) => a.forEach((value, k) =>
  assert.ok(Math.abs(value - b[k]) <= tolerance, `${what}, element ${k}: ${a} and ${b}`));

test('rotations: inverse, composition, interpolation and matrices agree', () => {
  for (let i = 0; i < 50; i++) {
    const [a, b, p] = [pose(), pose(), vector(3)];
    const place = ({ position, turn }, point) => rotated(turn, point)
      .map((each, k) => each + position[k]);
    near(place(compose(a, b), p), place(a, place(b, p)), 1e-9, 'composed');
    near(place(inverted(a), place(a, p)), p, 1e-9, 'inverted');
    near(transform(matrixOf(a), p).slice(0, 3), place(a, p), 1e-9, 'matrix');
    near(rotated(slerp(a.turn, b.turn, 0), p), rotated(a.turn, p), 1e-9, 'start');
    near(rotated(slerp(a.turn, b.turn, 1), p), rotated(b.turn, p), 1e-9, 'end');
    const [from, to] = [unit(vector(1)), unit(vector(1))];
    near(rotated(turnBetween(from, to), from), to, 1e-9, 'between');
  }
  // A third of the way beyond: the same speed about the same axis, the shorter way.
  const axis = unit([1, 2, -2]), far = turnAbout(axis, 0.9).map(each => -each);
  near(rotated(slerp(turnAbout(axis, 0.6), far, 4 / 3), [1, 0, 0]),
       rotated(turnAbout(axis, 1), [1, 0, 0]), 1e-9, 'beyond');
});

test('the patient stands upright before the viewer, faces the viewer, at natural size', () => {
  const placement = new Placement();
  const yaw = 0.7, head = { position: [0.3, 1.6, -0.2], turn: turnAbout(UP, yaw) };
  placement.home(SPHERE, head);
  const center = placement.toWorld(SPHERE.center_mm);
  near(center, [0.3 - 0.8 * Math.sin(yaw), 1.2, -0.2 - 0.8 * Math.cos(yaw)], 1e-9, 'center');
  near(placement.directionToWorld([0, 0, 1]), UP, 1e-9, 'superior is up');
  const toViewer = [Math.sin(yaw), 0, Math.cos(yaw)];
  near(placement.directionToWorld([0, -1, 0]), toViewer, 1e-9, 'anterior is towards the viewer');
  near(placement.directionToWorld([1, 0, 0]), [Math.cos(yaw), 0, -Math.sin(yaw)], 1e-9,
       'left is on the right, as in a radiograph');
  assert.equal(placement.magnification, 1);
  near(transform(placement.patientToWorld, [0, 0, 500]).slice(0, 3),
       placement.toWorld([0, 0, 500]), 1e-9, 'matrix');
  // A viewer who sits.
  placement.home(SPHERE, { position: [0, 1.1, 0], turn: turnAbout(UP, 0) });
  assert.ok(Math.abs(placement.toWorld(SPHERE.center_mm)[1] - 0.95) < 1e-9);
});

test('what is larger or smaller than a body is scaled, and the size is said', () => {
  const placement = new Placement(), head = { position: [0, 1.6, 0], turn: [0, 0, 0, 1] };
  for (const [radius_mm, magnification, text] of [[450, 2 / 3, '0.67 × natural size'],
                                                  [20, 5, '5 × natural size'],
                                                  [200, 1, 'natural size'],
                                                  [5, 20, '20 × natural size']]) {
    placement.home({ center_mm: [0, 0, 0], radius_mm }, head);
    assert.ok(Math.abs(placement.magnification - magnification) < 1e-9, `${radius_mm}`);
    assert.equal(sizeText(placement.magnification), text);
  }
});

test('hands: what is held stays in the hand; two hands stretch between them', () => {
  const placement = new Placement();
  placement.home(SPHERE, { position: [0, 1.6, 0], turn: [0, 0, 0, 1] });
  const hand = [pose(), pose()];
  const held = placement.toPatient(hand[0]);
  placement.follow(hand[0], hand[1]);
  const after = placement.toPatient(hand[1]);
  near(after.position, held.position, 1e-6, 'held');
  near(rotated(after.turn, [1, 2, 3]), rotated(held.turn, [1, 2, 3]), 1e-9, 'turned');

  const before = [[-0.2, 1.2, -0.7], [0.2, 1.2, -0.7]], now = [[0, 1, -0.7], [0, 1.6, -0.7]];
  const points = before.map(each => placement.toPatient({ position: each, turn: [0, 0, 0, 1] })
    .position);
  placement.stretch(before, now);
  points.forEach((point, k) => near(placement.toWorld(point), now[k], 1e-9, `hand ${k}`));
  assert.ok(Math.abs(placement.magnification - 1.5) < 1e-9);
  placement.stretch(now, [[0, 1, 0], [0, 1, 0]]);  // In one place: no scale follows from this.
  assert.ok(Math.abs(placement.magnification - 1.5) < 1e-9);
});

/** Points on the sphere. */
function points(count) {
  return Array.from({ length: count }, () => unit(vector(1)).map((each, k) =>
    SPHERE.center_mm[k] + each * SPHERE.radius_mm));
}

test('windows show the whole sphere, fill it, and do not turn with the head', () => {
  for (let i = 0; i < 40; i++) {
    const away = unit(vector(1)), distance = next(320, 2000);
    const middle = SPHERE.center_mm.map((each, k) => each + away[k] * distance);
    const side = unit(minus(vector(1), [0, 0, 0]));
    const eyes = [-32, 32].map(mm => middle.map((each, k) => each + side[k] * mm));
    const head = { position: middle, turn: pose().turn };
    const windows = windowsOf(eyes, head, [0, 0, 1], SPHERE);
    const turned = windowsOf(eyes, { ...head, turn: turnAbout([0, 0, 1], next(-2, 2)) }, [0, 0, 1],
                             SPHERE);
    if (Math.abs(away[2]) < 0.9) assert.deepEqual(turned, windows);
    windows.forEach(({ patient_to_eye: eye, projection }, k) => {
      near(transform(eye, eyes[k]).slice(0, 3), [0, 0, 0], 1e-6, 'the eye is at the origin');
      const most = [0, 0, 0];
      for (const point of points(2000)) {
        const [x, y, z, w] = transform(multiply(projection, eye), point);
        [x, y, z].forEach((each, axis) => {
          most[axis] = Math.max(most[axis], Math.abs(each / w));
        });
        assert.ok(w > 0);
      }
      assert.ok(most.every(each => each <= 1), `${most}`);
      assert.ok(distance < 450 || Math.min(most[0], most[1]) > 0.9, `${most} at ${distance} mm`);
    });
    near(windows[0].patient_to_eye.slice(0, 12), windows[1].patient_to_eye.slice(0, 12), 0,
         'both eyes have one orientation');
  }
});

test('from within the sphere, the windows look where the head looks', () => {
  const turn = turnAbout(unit([1, 2, 3]), 1), head = { position: SPHERE.center_mm, turn };
  const eyes = [-32, 32].map(mm => SPHERE.center_mm.map((each, k) =>
    each + rotated(turn, [mm, 0, 0])[k]));
  for (const { patient_to_eye: eye, projection } of windowsOf(eyes, head, [0, 0, 1], SPHERE)) {
    const ahead = rotated(turn, [0, 0, -1]).map((each, k) => SPHERE.center_mm[k] + 200 * each);
    assert.ok(Math.abs(transform(eye, ahead)[2] + 200) < 1e-6);
    assert.ok([...eye, ...projection].every(Number.isFinite));
  }
});

test('a window has the pixels that the headset shows, within limits, in steps', () => {
  const windows = [{ projection: [4, 0, 0, 0, 0, 2] }, { projection: [5, 0, 0, 0, 0, 2] }];
  const limits = { least: 128, most: 1024, step: 64 };
  assert.deepEqual(sizeOf(windows, 700, limits), [384, 704]);
  assert.deepEqual(sizeOf(windows, 100, limits), [128, 128]);
  assert.deepEqual(sizeOf(windows, 9000, limits), [1024, 1024]);
});

test('prediction: exact for a steady motion, the newest pose for a short past', () => {
  const track = new HeadTrack(), axis = unit([1, -1, 2]);
  const at = ms => ({ position: [ms * 0.3, 1600 - ms * 0.1, 5],
                      turn: turnAbout(axis, ms * 0.002) });
  assert.equal(track.predict(20), null);
  track.add(1000, at(1000));
  near(track.predict(20).pose.position, at(1000).position, 0, 'one sample');
  for (let ms = 1011; ms < 1200; ms += 11) track.add(ms, at(ms));
  const { at: time, pose: ahead } = track.predict(30);
  near(ahead.position, at(time).position, 1e-9, 'position');
  near(rotated(ahead.turn, [1, 0, 0]), rotated(at(time).turn, [1, 0, 0]), 1e-9, 'turn');
  near(track.at(1100.5).position, at(1100.5).position, 1e-9, 'in the past');
  assert.equal(track.at(track.newestAt + 1), null);
  assert.ok(track.predict(5000).at <= track.newestAt + 150, 'not too far');
});

test('the room: letters around the patient, lines on the floor, ink for the background', () => {
  const placement = new Placement(), head = { position: [0, 1.6, 0], turn: [0, 0, 0, 1] };
  placement.home(SPHERE, head);
  const scene = { placement, sphere: SPHERE, background: '#101820', head, hands: [], cut: null,
                  lengths: [], value: '', sentence: '' };
  const { lines, labels } = roomOf(scene);
  assert.deepEqual(labels.map(each => each.text).sort(),
                   ['A', 'I', 'L', 'P', 'R', 'S', 'natural size']);
  const a = labels.find(each => each.text === 'A'), s = labels.find(each => each.text === 'S');
  assert.ok(a.at[2] > -0.8 + 0.25 && s.at[1] > 1.2 + 0.25, `${a.at} ${s.at}`);
  assert.ok(lines.length > 100 && lines.every(({ from, to }) => from[1] === 0 && to[1] === 0));
  assert.ok(isLight('#ffffff') && !isLight('#101820'));
  assert.notEqual(roomOf({ ...scene, background: '#ffffff' }).labels[0].color, labels[0].color);
  const cut = roomOf({ ...scene, cut: { letter: 'L', at_mm: 12 } }).lines.slice(lines.length);
  assert.equal(cut.length, 4);
  for (const { from } of cut) assert.ok(Math.abs(from[0]) < 1e-9, `${from}`);
  const only = roomOf({ ...scene, sphere: null, sentence: 'No volume is open.' }).labels;
  assert.deepEqual(only.map(each => each.text), ['No volume is open.']);
  assert.ok(length(minus(only[0].at, head.position)) < 0.6);
});
