// A walk through all parts of the page, in any language.
import { settled, unfold } from '../steps.js';

/** The address of the page in a language. */
export function inLanguage(address, code) {
  const url = new URL(address);
  url.searchParams.set('lang', code);
  return url.href;
}

/** Shows each panel in turn, and calls `look` with its name. */
export async function allPanels(page, look) {
  await settled(page);
  await unfold(page);
  for (const tab of await page.getByRole('tab').all()) {
    await tab.click();
    await settled(page);
    await unfold(page);
    await look(`panel-${(await tab.getAttribute('data-testid')).replace('tab-', '')}`);
  }
}

/** Shows each step of the tour in turn. */
export async function allSteps(page, look) {
  await page.keyboard.press('t');
  const steps = page.locator('[data-testid^=tour-link-]');
  await steps.first().waitFor();
  for (let step = 0; step < await steps.count(); ++step) {
    await steps.nth(step).click();
    await settled(page);
    // The step waits for answers until then.
    await page.getByTestId('tour-message').filter({ hasNotText: '…' }).waitFor({
      state: 'attached' });
    await look(`tour-${step + 1}`);
  }
  await page.keyboard.press('Escape');
}

/** Shows each part of the page in turn. */
export async function everywhere(page, look) {
  await allPanels(page, look);
  for (const key of ['8', '9', '0', '7']) {
    await page.keyboard.press(key);
    await settled(page);
    await look(`layout-${key}`);
  }
  await page.getByTestId('view-menu').click();
  await look('menu');
  await page.keyboard.press('Escape');
  for (const [key, name] of [['?', 'help'], ['o', 'open'], ['s', 'save']]) {
    await page.keyboard.press(key);
    await page.locator('dialog[open]').waitFor();
    await unfold(page);
    await look(`dialog-${name}`);
    await page.keyboard.press('Escape');
  }
  await allSteps(page, look);
}
