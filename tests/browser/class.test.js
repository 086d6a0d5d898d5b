// A class: students open one address, and each gets a session.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import path from 'node:path';
import test from 'node:test';
import { bin, browser, openPage, server, shoot, useServer } from './harness.js';
import { ofPort } from '../../host/serve/page/link/ports.js';
import { after, settled, state } from './steps.js';

useServer(['phantom:sphere', '--sessions', '2', '--topology', 'one-of-each']);

/** Process ids of the sessions, in the order of their start. */
function sessions() {
  const listed = execFileSync(path.join(bin, 'pxpl5'),
    ['sessions', '--json', '--run-folder', path.join(server.folder, 'run')]);
  return JSON.parse(listed).sessions.map(each => each.pid);
}

test('students open one address and work apart, and a session that has ended begins anew',
  async () => {
    const ann = await openPage(browser, server.url);
    const bob = await openPage(browser, server.url);
    assert.notEqual(new URL(ann.page.url()).port, new URL(server.url).port);
    assert.notEqual(new URL(ann.page.url()).port, new URL(bob.page.url()).port);
    await after(ann.page, () => ann.page.getByTestId('stage').press('ArrowLeft'));
    await settled(bob.page);
    assert.notDeepEqual((await state(ann.page)).camera, (await state(bob.page)).camera);

    // A third student waits, and gets the place of the first.
    const context = await browser.newContext({ viewport: { width: 390, height: 700 } });
    const eve = await context.newPage();
    await eve.goto(server.url);
    await eve.getByRole('heading', { name: 'All 2 sessions are taken' }).waitFor();
    await shoot(eve, 'class-full-390');

    // A reader of German gets this page in German. The address may ask for it, of the session, too.
    const german = await browser.newContext({ locale: 'de-AT',
                                              viewport: { width: 390, height: 700 } });
    const uwe = await german.newPage();
    await uwe.goto(server.url);
    await uwe.getByRole('heading', { name: 'Alle 2 Sitzungen sind vergeben' }).waitFor();
    assert.equal(await uwe.locator('html').getAttribute('lang'), 'de');
    await shoot(uwe, 'class-full-german-390');
    await eve.goto(`${server.url}&lang=de`);
    await eve.getByRole('heading', { name: 'Alle 2 Sitzungen sind vergeben' }).waitFor();
    await german.close();
    await bob.page.goto(`${server.url}&lang=de`);
    await settled(bob.page);
    assert.equal(await bob.page.locator('html').getAttribute('lang'), 'de');

    // The same address opens the same session again.
    const mine = ann.page.url();
    await ann.page.goto(server.url);
    await settled(ann.page);
    assert.equal(ann.page.url(), mine);

    process.kill(sessions()[0], 'SIGTERM');
    const link = ann.page.getByTestId('class');
    await link.waitFor();
    await shoot(ann.page, 'class-ended-1280');
    await link.click();
    await ann.page.getByRole('heading', { name: 'Your session has ended' }).waitFor();
    assert.match(await ann.page.locator('p').innerText(),
                 /^The session was asked to end, by .* signal\. Reload/);
    await ann.page.reload();
    await ann.page.waitForFunction(() => globalThis.pxpl5?.frames > 0 ||
      document.body?.innerText.includes('are taken'));
    await ann.context.close();  // The lost connection was said in its console.
    await context.close();
    await bob.close();
  });

test('the page of the class lies at its port, with and without a portal', () => {
  assert.equal(ofPort(8000, 'http://lab1:8003/'), 'http://lab1:8000/');
  assert.equal(ofPort(8000, 'https://[::1]:8003/?a=1'), 'https://[::1]:8000/');
  assert.equal(ofPort(8000, 'https://p.example/rnode/n1/8003/'),
               'https://p.example/rnode/n1/8000/');
});
