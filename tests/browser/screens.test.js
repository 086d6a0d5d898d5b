// The page as a person sees it, kept as screenshots: on a laptop, a desk, and a large screen.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, openPage, server, shoot, useServer } from './harness.js';
import { after, drag, lookAtPicture, middleOf, settled, unfold } from './steps.js';

const SIZES = [[1280, 720], [1920, 1080]];
const LARGE = [3840, 2160];

useServer(['phantom:pelvis']);

/** Keeps a screenshot of a page that has come to rest with a picture on it. */
async function keep(page, name) {
  await settled(page);
  const { colors } = await lookAtPicture(page);
  assert.ok(colors > 200, `${name}: ${colors} colors`);
  await shoot(page, name);
}

for (const [width, height] of SIZES) {
  test(`screens of ${width} x ${height}`, async () => {
    const { page, close } = await openPage(browser, server.url,
      { viewport: { width, height }, colorScheme: 'dark' });
    const byId = id => page.getByTestId(id);
    await keep(page, `first-visit-${width}`);

    const grip = await middleOf(byId('handle-bone').locator('.reach'));
    await page.mouse.move(grip.x, grip.y);
    await page.mouse.down();
    await page.mouse.move(grip.x - 8, grip.y, { steps: 6 });
    await keep(page, `threshold-${width}`);
    await page.mouse.move(grip.x, grip.y, { steps: 6 });
    await page.mouse.up();

    await byId('surface-visible-skin').uncheck();
    const stage = await middleOf(byId('stage'));
    await after(page, () => drag(page, stage, { x: stage.x + 70, y: stage.y + 30 }));
    await keep(page, `slices-${width}`);
    await byId('tab-inspector').click();
    await byId('inspect-mode').click();
    await page.mouse.click(stage.x, stage.y - 20);
    await byId('scrub-status').getByText('instructions executed').waitFor();
    await keep(page, `inspector-${width}`);
    await page.keyboard.press('Escape');
    await byId('tab-machine').click();
    await byId('node-gp-0').waitFor();
    await drag(page, stage, { x: stage.x + 40, y: stage.y }, { steps: 30 });
    await keep(page, `machine-${width}`);
    await byId('model-go').click();
    await byId('model-use').last().waitFor();
    await byId('model').evaluate(element => element.scrollIntoView({ block: 'start' }));
    await keep(page, `model-${width}`);

    await byId('surface-visible-skin').check();
    await unfold(page);
    await after(page, () => byId('clip-add-L').click(), now => now.clips.length === 1);
    await byId('tab-volume').click();
    await keep(page, `clip-${width}`);
    await after(page, () => byId('clip-off-L').click(), now => now.clips.length === 0);
    await page.keyboard.press('r');
    await close();
  });
}

test('a first visit on a large screen', async () => {
  const [width, height] = LARGE;
  const { page, close } = await openPage(browser, server.url,
      { viewport: { width, height }, colorScheme: 'dark' });
  await keep(page, `first-visit-${width}`);
  await close();
});
