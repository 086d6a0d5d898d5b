// The page for everybody: names for those who hear it, contrast, keyboard, sizes of screens; and
// nothing asked of any other host.
import assert from 'node:assert/strict';
import test from 'node:test';
import { lookFor } from './layout.js';
import { browser, openPage, server, shoot, useServer } from './harness.js';
import { settled, unfold } from './steps.js';

const SIZES = [[1280, 720], [1920, 1080], [390, 844]];
const MOST_TABS = 400;  // Key presses until each control must have had its turn.

let opened;

useServer();
test.beforeEach(async () => {
  opened = await openPage(browser, server.url);
  await unfold(opened.page);
  await settled(opened.page);
});
test.afterEach(async () => opened.close());

/** Does something with each tab in front, and gathers what it finds. */
async function withEachTab(page, act) {
  const found = [];
  for (const tab of await page.getByRole('tab').all()) {
    await tab.click();
    const name = await tab.innerText();
    found.push(...(await act(name)).map(each => `${name}: ${each}`));
  }
  return [...new Set(found)];
}

test('every control has a name for those who hear the page', async () => {
  const { page, context } = opened;
  const session = await context.newCDPSession(page);
  const roles = new Set(['button', 'checkbox', 'combobox', 'link', 'menuitem', 'radio', 'slider',
                       'spinbutton', 'switch', 'tab', 'textbox', 'application', 'ColorWell']);
  let heard = 0;
  const nameless = await withEachTab(page, async () => {
    const { nodes } = await session.send('Accessibility.getFullAXTree');
    const controls = nodes.filter(node => !node.ignored && roles.has(node.role?.value));
    heard = Math.max(heard, controls.length);
    return controls.filter(node => !node.name?.value?.trim())
      .map(node => `${node.role.value} without a name, DOM node ${node.backendDOMNodeId}`);
  });
  assert.deepEqual(nameless, []);
  assert.ok(heard > 20, `${heard} controls`);
});

test('text stands out from what is behind it by 4.5 to 1', async () => {
  const { page } = opened;
  assert.deepEqual(await withEachTab(page, () => page.evaluate(lookFor.faintText)), []);
});

/** What Tab does not reach, or does not show, from the first control on. */
async function walkByTab(page) {
  const wanted = await page.evaluate(lookFor.markFocusable);
  assert.ok(wanted.length > 10, `${wanted.length} controls`);
  await page.locator('[data-mark="0"]').focus();
  const reached = new Set(['0']);
  const unseen = [];
  for (let i = 0; i < MOST_TABS && reached.size < wanted.length; i++) {
    await page.keyboard.press('Tab');
    const { mark, visible, what } = await page.evaluate(lookFor.focused);
    if (mark === null) break;  // Past the last one.
    reached.add(mark);
    if (!visible) unseen.push(`nothing shows that ${what} has the focus`);
  }
  return [...unseen, ...wanted.filter(({ mark }) => !reached.has(mark))
    .map(({ what }) => `Tab does not reach ${what}`)];
}

test('Tab reaches every control, and shows where it is', async () => {
  const { page } = opened;
  const faults = await withEachTab(page, async () => {
    await settled(page);
    const first = await walkByTab(page);
    // A state that arrives meanwhile may draw a list again, whose new controls have no marks.
    return first.length > 0 ? walkByTab(page) : first;
  });
  assert.deepEqual(faults, []);
});

for (const [width, height] of SIZES) {
  test(`nothing overflows or lies over another at ${width} x ${height}`, async () => {
    const { page } = opened;
    await page.setViewportSize({ width, height });
    await settled(page);
    const faults = await withEachTab(page, async tab => {
      if (width === 390) await shoot(page, `phone-${tab}`);
      return page.evaluate(lookFor.misplaced);
    });
    assert.deepEqual(faults, []);
    const stage = await page.getByTestId('frame').boundingBox();
    assert.ok(stage.width >= 200 && stage.height >= 200, `picture of ${JSON.stringify(stage)}`);
  });
}

test('no request leaves the server, whatever is shown', async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  const asked = [];
  page.on('request', request => asked.push(request.url()));
  page.on('websocket', socket => asked.push(socket.url().replace('ws:', 'http:')));
  await page.goto(server.url);
  await settled(page);
  await withEachTab(page, async () => []);
  await page.keyboard.press('?');
  const { origin } = new URL(server.url);
  assert.deepEqual(asked.filter(url => !url.startsWith(`${origin}/`) &&
    !url.startsWith(`blob:${origin}/`) && !url.startsWith('data:')), []);
  for (const name of ['/main.js', '/page.css', '/socket']) {
    assert.ok(asked.some(url => new URL(url).pathname === name), `${name}: ${asked.join(' ')}`);
  }
  await context.close();
});
