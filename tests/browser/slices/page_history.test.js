// One undo for scene and measurements: the modules that need no browser.
import assert from 'node:assert/strict';
import test from 'node:test';

import {Measures} from '../../../host/serve/page/panel/measures.js';
import {OneHistory} from '../../../host/serve/page/panel/one_history.js';
import {Store} from '../../../host/serve/page/state/store.js';

const AT = /** @type {any} */ ({kind: 'distance', points_mm: [[0, 0, 0], [0, 3, 4]], value: 5});

/** A page with a server whose replies and states come when a test says so. */
function desk({watches = false} = {}) {
  const store = new Store();
  const lines = ['load'];
  let step = 0, revision = 0;
  /** @type {(() => void)[]} */
  const late = [];
  const tell = () => store.take(/** @type {any} */ ({revision, step,
    undo: lines[step] && step > 0 ? lines[step] : null, redo: lines[step + 1] ?? null}));
  const sent = /** @type {string[]} */ ([]);
  const connection = /** @type {any} */ ({
    watches, on() {}, mark: () => sent.push('mark'),
    do(/** @type {string} */ line) {
      sent.push(line);
      return new Promise(take => late.push(() => {
        step += line === 'undo' ? -1 : 1;
        take({ok: true, revision: ++revision});
      }));
    },
  });
  const measures = new Measures();
  const history = new OneHistory(connection, store, measures);
  tell();
  return {measures, history, sent,
    /** The scene changes. */
    change(/** @type {string} */ line) {
      lines.splice(step + 1, Infinity, line);
      ++step;
      ++revision;
      tell();
    },
    /** Replies to all commands, then sends the state. */
    async catchUp() {
      late.splice(0).forEach(act => act());
      await Promise.resolve();
      tell();
      await Promise.resolve();
    },
    names: () => measures.list.map(({name}) => name).join(),
    titles: () => [history.title('undo'), history.title('redo')]};
}

test('undo goes back through scene and measurements in their order, and redo forward', async () => {
  const {measures, history, change, catchUp, names, titles} = desk();
  change('iso 1');
  measures.add(AT);
  change('iso 2');
  change('iso 3');
  measures.rename('1', 'neck');
  measures.remove('neck');
  const seen = [];
  while (titles()[0] !== null) {
    seen.push(titles()[0]);
    history.go('undo');
    await catchUp();
  }
  assert.deepEqual(seen, ['delete measurement neck', 'rename measurement 1 to neck', 'iso 3',
    'iso 2', 'add distance 1', 'iso 1']);
  assert.equal(names(), '');
  const again = [];
  while (titles()[1] !== null) {
    again.push(titles()[1]);
    history.go('redo');
    await catchUp();
  }
  assert.deepEqual(again, seen.reverse());
  assert.equal(names(), '');
});

test('the order is right although the server replies later', async () => {
  const {measures, history, sent, change, catchUp, names} = desk();
  measures.add(AT);
  change('iso 1');
  change('iso 2');
  for (let press = 0; press < 3; ++press) {
    history.go('undo');
  }
  assert.deepEqual(sent, ['mark', 'undo', 'undo']);
  assert.equal(names(), '');
  await catchUp();
  for (let press = 0; press < 3; ++press) {
    history.go('redo');
  }
  assert.equal(names(), '1');
  assert.deepEqual(sent, ['mark', 'undo', 'undo', 'redo', 'redo']);
});

test('a new step of the scene forgets undone measurements, as a new measurement does', async () => {
  const {measures, history, change, titles, names} = desk();
  measures.add(AT);
  history.go('undo');
  assert.deepEqual(titles(), [null, 'add distance 1']);
  change('iso 1');
  assert.deepEqual(titles(), ['iso 1', null]);
  measures.add(AT);
  history.go('undo');
  measures.add(AT);
  assert.deepEqual(titles(), ['add distance 3', null]);
  assert.equal(names(), '3');
});

test('a drag is one step; undo in the middle of a drag takes it back', () => {
  const {measures, history, titles} = desk();
  measures.add(AT);
  for (const value of [6, 7, 8]) {
    measures.drag('1', {value});
  }
  measures.drop();
  assert.equal(measures.list[0].value, 8);
  assert.equal(titles()[0], 'move an end of measurement 1');
  history.go('undo');
  assert.equal(measures.list[0].value, 5);
  measures.drag('1', {value: 9});
  history.go('undo');
  assert.equal(measures.list[0].value, 5);
  history.go('undo');
  assert.deepEqual(measures.list, []);
});

test('a drag that is put back is no step', () => {
  const {measures, titles} = desk();
  measures.add(AT);
  measures.drag('1', {value: 6});
  measures.putBack();
  assert.equal(measures.list[0].value, 5);
  assert.equal(titles()[0], 'add distance 1');
});

test('a view-only page undoes its measurements alone', () => {
  const {measures, history, sent, change, titles} = desk({watches: true});
  measures.add(AT);
  change('iso 1');
  assert.deepEqual(titles(), ['add distance 1', null]);
  history.go('undo');
  assert.deepEqual(measures.list, []);
  history.go('undo');
  assert.deepEqual(sent, []);
});

test('another volume and a session begin without steps', () => {
  const {measures, titles} = desk();
  measures.add(AT);
  measures.clear();
  assert.deepEqual(titles(), [null, null]);
  measures.add(AT);
  measures.restore([{...AT, name: '7'}]);
  assert.deepEqual(titles(), [null, null]);
});

test('a name is not empty, and no other measurement has it', () => {
  const {measures, names, titles} = desk();
  measures.add(AT);
  measures.add(AT);
  assert.match(measures.rename('2', ' 1 '), /already a measurement 1/);
  assert.match(measures.rename('2', ' '), /empty/);
  assert.equal(titles()[0], 'add distance 2');
  assert.equal(measures.rename('2', '3'), '');
  measures.add(AT);
  assert.equal(names(), '1,3,4', 'the number of a new measurement is not taken');
});
