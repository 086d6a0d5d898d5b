// The first visit: the hint and what it hides, and the help sheet, which must name every key that
// does something, and no other.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, usePage } from '../harness.js';
import { lookFor } from '../layout.js';
import { middleOf, settled } from '../steps.js';

usePage();

/** In the page: presses all keys on an element; returns those that the page uses. */
function keysUsedBy(element) {
  const letters = Array.from({ length: 94 }, (_, at) => String.fromCharCode(33 + at));
  const names = ['ArrowLeft', 'ArrowUp', 'ArrowRight', 'ArrowDown', 'PageUp', 'PageDown', 'Home',
               'End', 'Escape', 'Enter', ' ', 'Tab', 'Backspace', 'Delete', 'Insert', 'F1'];
  const isShifted = key => /^[A-Z]$/.test(key);
  const presses = [
    ...[...letters, ...names].map(key => [isShifted(key) ? `Shift+${key}` : key,
      { key, shiftKey: isShifted(key) }]),
    ...names.map(key => [`Shift+${key}`, { key, shiftKey: true }]),
    ...letters.filter(key => /^[a-z]$/.test(key)).map(key => [`Control+${key}`,
      { key, ctrlKey: true }]),
    ...letters.filter(isShifted).map(key => [`Control+Shift+${key}`,
      { key, ctrlKey: true, shiftKey: true }]),
  ];
  return presses.filter(([, press]) => {
    const event = new KeyboardEvent('keydown', { ...press, bubbles: true, cancelable: true });
    element.dispatchEvent(event);
    for (const dialog of document.querySelectorAll('dialog[open]')) dialog.close();
    return event.defaultPrevented;
  }).map(([name]) => name);
}

/** In the page: the keys that a section of the help sheet names. */
function keysTold(title) {
  const section = [...document.querySelectorAll('#help section')]
    .find(each => each.querySelector('h3').textContent === title);
  return [...section.querySelectorAll('dt[data-keys]')]
    .flatMap(each => each.dataset.keys.split(' '));
}

/** Closes the tour, which the key T has opened, and opens the sides that keys have hidden. */
async function restore() {
  await byId('tour').waitFor();
  await byId('stage').evaluate(element => {
    const press = key =>
      element.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    press('Escape');
    press('7');
    const { classList } = document.querySelector('main');
    if (classList.contains('no-left')) press(',');
    if (classList.contains('no-right')) press('.');
  });
  await byId('tour').waitFor({ state: 'hidden' });
  await byId('tab-slices').waitFor();
}

/** Without what Shift does not change, where a section does not tell Shift apart. */
const plain = keys => [...new Set(keys.map(key => key.replace(/^Shift\+(?=..)/, '')))].sort();

test('the help names the keys of the page, all of them and no other', async () => {
  const used = await byId('stage').evaluate(keysUsedBy);
  assert.deepEqual(used.toSorted(), (await page.evaluate(keysTold, 'Keys')).toSorted());
  await restore();
});

test('the help names the keys of a slice, a handle and the instructions', async () => {
  await byId('tab-slices').click();
  const shared = ['?', ',', '.', 'Escape', 'Shift+Escape'];
  const isOwn = key => !shared.includes(key) &&
    !/^(Control\+|Shift\+U)|^[1-9a-z]$/.test(key);  // The keys of the page work there, too.
  const onSlice = (await byId('slice-axial').evaluate(keysUsedBy)).filter(isOwn);
  assert.deepEqual(plain(onSlice), plain(await page.evaluate(keysTold, 'Keys on a slice')));
  await restore();
  const onHandle = (await byId('handle-bone').evaluate(keysUsedBy)).filter(isOwn);
  assert.deepEqual(plain(onHandle),
                   plain(await page.evaluate(keysTold, 'Keys on a handle of the histogram')));
  await settled(page);
  await byId('tab-inspector').click();
  const { x, y } = await middleOf(byId('stage'));
  await byId('inspect-mode').click();
  await page.mouse.click(x, y - 30);
  await byId('scrub-status').getByText('executed').waitFor();
  const onStream = (await byId('scrub-play').evaluate(keysUsedBy))
    .filter(key => isOwn(key) && !['+', '=', '-', '0'].includes(key));
  assert.deepEqual(plain(onStream),
                   plain(await page.evaluate(keysTold, 'Keys on the instructions of a region')));
  await restore();
});

test('the help offers the tour', async () => {
  await byId('help').click();
  await byId('help-tour').click();
  await byId('tour-title').waitFor();
  await byId('help-sheet').waitFor({ state: 'hidden' });
  await byId('tour-close').click();
});

test('the hint of a first visit offers the tour, hides no control, and goes when it is used',
     async t => {
  const visit = await openPage(browser, server.url);
  t.after(() => visit.context.close());
  const id = name => visit.page.getByTestId(name);
  await settled(visit.page);
  await id('hint').getByText('New here? Take the tour').waitFor();
  assert.deepEqual(await visit.page.evaluate(lookFor.misplaced), []);
  await id('hint-tour').click();
  await id('tour-title').waitFor();
  await id('hint').waitFor({ state: 'hidden' });
  await visit.page.reload();
  await id('tour-title').waitFor();  // The address names it.
  await settled(visit.page);
  assert.ok(await id('hint').isHidden());
  assert.deepEqual(visit.complaints, []);
});

test('the hint of a view-only page says what works there', async t => {
  const visit = await openPage(browser, server.watchUrl);
  t.after(() => visit.context.close());
  const hint = visit.page.getByTestId('hint');
  await hint.getByText('This page is view-only').waitFor();
  await visit.page.getByTestId('tab-machine').click();
  await hint.waitFor({ state: 'hidden' });
});
