// The page's store of the server's state: its subscribers, how often they are called, old values.
import assert from 'node:assert/strict';
import test, {mock} from 'node:test';
import {mayBeOld, show, touch} from '../../../host/serve/page/panel/gesture.js';
import {paced} from '../../../host/serve/page/state/paced.js';
import {Store} from '../../../host/serve/page/state/store.js';

test('the store tells of what has changed, and of nothing else', () => {
  const store = new Store();
  /** @type {string[]} */
  const told = [];
  store.subscribe(['camera'], () => told.push('camera'));
  store.subscribe(['size'], () => told.push('size'));
  const state = /** @type {any} */ ({revision: 1, camera: {zoom: 1}, size: [1, 1]});
  store.take(state);
  store.take({...state, revision: 2, camera: {zoom: 1}});
  store.take({...state, revision: 3, camera: {zoom: 2}});
  assert.deepEqual(told, ['camera', 'size', 'camera']);
});

test('a paced function acts at once, then not too often, and once more at the end', () => {
  mock.timers.enable({apis: ['setTimeout']});
  let time = 1000;
  const done = [];
  const act = paced(() => done.push(time), 100, () => time);
  const at = next => {
    mock.timers.tick(next - time);
    time = next;
    act();
  };
  act();
  at(1040);
  at(1099);
  assert.deepEqual(done, [1000]);
  time = 1100;
  mock.timers.tick(1);
  assert.deepEqual(done, [1000, 1100], 'the last calls had their effect');
  at(1150);
  at(1160);
  time = 1200;
  mock.timers.tick(40);
  assert.deepEqual(done, [1000, 1100, 1200]);
  at(1300);
  assert.deepEqual(done, [1000, 1100, 1200, 1300], 'after a rest, at once');
  mock.timers.tick(1000);
  assert.equal(done.length, 4, 'no call without a reason');
  mock.timers.reset();
});

test('a follower of the store gets the newest state, not each', () => {
  mock.timers.enable({apis: ['setTimeout']});
  const store = new Store();
  const seen = [];
  store.follow(['camera'], ({camera}) => seen.push(camera));
  assert.deepEqual(seen, [], 'there is no state yet');
  const zoomTo = (zoom, revision) =>
    store.take(/** @type {any} */ ({revision, camera: zoom, size: [1, 1]}));
  zoomTo(1, 1);
  assert.deepEqual(seen, [1]);
  zoomTo(2, 2);
  zoomTo(3, 3);
  mock.timers.tick(1000);
  assert.equal(seen.at(-1), 3);
  const {length} = seen;
  zoomTo(3, 4);
  mock.timers.tick(1000);
  assert.equal(seen.length, length, 'the camera is the same');
  mock.timers.reset();
});

test('a value that is older than the input of a field is known as such, until it is equal', () => {
  const field = value => /** @type {any} */ ({type: 'range', value, matches: () => false});
  const slider = field('0.5');
  assert.equal(mayBeOld(slider, '0.25'), false, 'it was not used');
  touch(slider);
  assert.equal(mayBeOld(slider, '0.25'), true);
  assert.equal(mayBeOld(slider, '0.5'), false, 'the state has reached the input');
  assert.equal(mayBeOld(slider, '0.25'), false, 'what follows is newer, for example an undo');
  const tick = {...field('on'), type: 'checkbox', checked: true};
  touch(tick);
  assert.equal(mayBeOld(tick, false), true);
  assert.equal(mayBeOld(tick, true), false);
  assert.equal(mayBeOld(tick, false), false);
});

test('a value that may be old is shown later, unless a newer one comes', () => {
  mock.timers.enable({apis: ['setTimeout']});
  let time = 1000;
  mock.method(performance, 'now', () => time);
  const wait = ms => {
    time += ms;
    mock.timers.tick(ms);
  };
  const tick = /** @type {any} */ ({type: 'checkbox', checked: true, matches: () => false});
  touch(tick);
  show(tick, false);
  assert.equal(tick.checked, true, 'the state of before the input');
  wait(100);
  show(tick, true);
  show(tick, false);
  assert.equal(tick.checked, false, 'the input, and an undo');
  touch(tick);
  tick.checked = true;
  show(tick, false);
  wait(1000);
  assert.equal(tick.checked, false, 'the command failed: the state does not change');
  const slider = /** @type {any} */ ({type: 'range', value: '0.5', matches: () => false});
  touch(slider);
  show(slider, '0.25');
  show(slider, '0.375');
  assert.equal(slider.value, '0.5');
  wait(1000);
  assert.equal(slider.value, '0.375', 'the newest of both');
  mock.reset();
  mock.timers.reset();
});
