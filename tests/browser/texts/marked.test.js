// No text of the page has only English: each is one of the texts that are translated.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { browser, openPage, server, useServer } from '../harness.js';
import { openWithHeadset, settledPair, wear } from '../headset/emulated.js';
import { drop, settled } from '../steps.js';
import { allPanels, allSteps, everywhere, inLanguage } from './everywhere.js';
import { Findings, keepWriting } from './marks.js';

useServer(['phantom:heart', 'resample=48x48x48']);

/** Opens the page with marks. */
function openMarked(options = {}, address = server.url) {
  return openPage(browser, inLanguage(address, 'marked'), { scripts: [keepWriting], ...options });
}

test('what is not translated is found: as an element, a part of a text, in a canvas', async () => {
  const { page, close } = await openMarked();
  await settled(page);
  await page.evaluate(() => {
    const mark = text => `⟦${text}⟧`;
    for (const [id, text] of [['whole', 'Plain'], ['part', `${mark('Limit: ')}busy${mark(' %')}`],
      ['good', `${mark('Limit: ')}${mark('busy')}${mark(' %')}`]]) {
      const element = document.createElement('p');
      element.id = id;
      element.textContent = text;
      document.body.append(element);
    }
    document.createElement('canvas').getContext('2d').fillText('Drawn', 0, 0);
  });
  const findings = new Findings();
  await findings.look(page, 'here');
  assert.deepEqual(findings.all.map(each => each.split(':')[1].trim()).sort(),
                   ['Drawn (canvas)', 'Plain (whole)', 'busy (part)']);
  await close();
});

test('every text of the page comes from the texts that are translated', async () => {
  const { page, close } = await openMarked();
  const findings = new Findings();
  await everywhere(page, where => findings.look(page, where));
  assert.deepEqual(findings.all, []);
  await close();
});

test('so does every text of a view-only page', async () => {
  const { page, close } = await openMarked({}, server.watchUrl);
  const findings = new Findings();
  await allPanels(page, where => findings.look(page, where));
  await allSteps(page, where => findings.look(page, where));
  assert.deepEqual(findings.all, []);
  await close();
});

/**
 * Runs in the page before its own code: `hear(data)` gives the page a message as if the server had
 * sent it, `spoil(line)` sends this line instead of the next view, `lose()` ends the connection,
 * and no other can be opened.
 */
function meddle() {
  const Plain = globalThis.WebSocket;
  let socket, line = '', isRefused = false;
  globalThis.hear = data => socket.onmessage({ data });
  globalThis.spoil = other => { line = other; };
  globalThis.lose = () => {
    isRefused = true;
    socket.close();
  };
  globalThis.WebSocket = class extends Plain {
    constructor(url) {
      super(isRefused ? new URL('no-socket', url) : url);
      socket = this;
    }
    send(text) {
      const message = JSON.parse(text);
      if (line !== '' && message.do?.startsWith('view ')) {
        message.do = line;
        line = '';
      }
      super.send(JSON.stringify(message));
    }
  };
}

/** A file in the server's folder. */
function written(name, contents) {
  const file = path.join(server.folder, name);
  writeFileSync(file, contents);
  return file;
}

/** What can go wrong: the name, how it is brought about, and where the page says so. */
const WRONG = [
  ['a refused command', page => page.evaluate(() => globalThis.spoil('view sideways'))
    .then(() => page.getByTestId('stage').press('ArrowLeft')), 'toast-error'],
  ['a note', page => page.evaluate(() =>
    globalThis.hear('{"note":{"level":"error","text":"A node has ended."}}')), 'toast-error'],
  ['an odd message', page => page.evaluate(() => globalThis.hear(new ArrayBuffer(3))),
    'toast-error'],
  ['a damaged archive', page => drop(page, [written('scan.zip', 'PK, but no archive')]),
    'toast-error'],
  ['an upload that fails', async page => {
    await page.route('**/upload/**', route => route.abort());
    await drop(page, [written('scan.nrrd', 'NRRD')]);
  }, 'toast-error'],
  ['a session with wrong parts', async page => {
    await page.unroute('**/upload/**');
    const parts = { window: 1, slices: 1, crosshair: 0, measurements: [{ kind: 'angle' }] };
    await drop(page, [written('wrong.pxpl5',
      `load phantom:heart resample=48x48x48\n# page ${JSON.stringify(parts)}\n`)]);
  }, 'toast-error'],
  ['a path that does not exist', async page => {
    await page.keyboard.press('o');
    await page.getByTestId('open-path').fill('/nowhere/scan.nrrd');
    await page.getByTestId('open-go').click();
  }, 'open-error'],
  ['a wrong size of a picture', async page => {
    await page.keyboard.press('Escape');
    await page.keyboard.press('s');
    await page.getByTestId('save-picture-size').selectOption('free');
    await page.getByTestId('save-picture-size-width').fill('0');
    await page.getByTestId('snapshot').click();
  }, 'save-picture-wrong'],
  ['a pixel outside of the picture', async page => {
    await page.keyboard.press('Escape');
    await page.getByTestId('tab-inspector').click();
    await page.getByTestId('why-x').fill('4000');
    await page.getByTestId('why-y').fill('4000');
    await page.getByTestId('why-ask').click();
  }, 'inspector-message'],
  ['a lost connection', page => page.evaluate(() => globalThis.lose()), 'lost'],
];

test('so does every refusal and error', async () => {
  const { page, context } = await openMarked({ scripts: [keepWriting, meddle] });
  await settled(page);
  // The files, a field of the session, and a surface of the volume that was open before.
  const findings = new Findings(['scan', 'zip', 'nrrd', 'name', 'blood']);
  for (const [what, bring, where] of WRONG) {
    await page.evaluate(() => document.getElementById('toasts').replaceChildren());
    await bring(page);
    await page.locator(`[data-testid=${where}]:visible`).filter({ hasText: /\w/ }).first()
      .waitFor();
    await findings.look(page, what);
  }
  assert.deepEqual(findings.all, []);
  await context.close();  // The lost connection was said in its console.
});

test('so does everything about a headset: its help, the strip, the room and the end', async () => {
  const { page, close } = await openWithHeadset(browser, inLanguage(server.url, 'marked'),
                                                { scripts: [keepWriting] });
  const findings = new Findings();
  await page.getByTestId('headset').waitFor();
  await page.keyboard.press('?');
  await page.getByTestId('headset-help').locator('dt').first().waitFor();
  await findings.look(page, 'help');
  await page.keyboard.press('Escape');
  await wear(page);
  await settledPair(page);
  await findings.look(page, 'worn');
  await page.evaluate(() => globalThis.headset.activeSession.end());
  await page.getByTestId('toast-info').waitFor();
  await findings.look(page, 'end');
  assert.ok(await page.evaluate(() => globalThis.written.size) > 0, 'the room has texts');
  assert.deepEqual(findings.all, []);
  await close();
});
