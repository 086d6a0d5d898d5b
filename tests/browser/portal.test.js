// The page behind a portal, whose paths have a prefix that the portal removes or leaves.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { createInterface } from 'node:readline';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import { browser, openPage, server, useServer } from './harness.js';
import { after, settled, state, stateWhen } from './steps.js';

const SIDE = 8;

const program = fileURLToPath(new URL('../host/serve/portal.py', import.meta.url));
const portal = spawn('python3', ['-B', program], { stdio: ['pipe', 'pipe', 'inherit'] });
const [port] = await new Promise(resolve =>
  createInterface({ input: portal.stdout }).once('line', line => resolve([line])));
test.after(() => portal.stdin.end());

useServer(['phantom:sphere', '--allow-host', `127.0.0.1:${port}`]);

/** A volume of SIDE voxels in each direction, in a file. */
function writeVolume(file) {
  const header = ['NRRD0004', 'type: uint8', 'dimension: 3', `sizes: ${SIDE} ${SIDE} ${SIDE}`,
                  'encoding: raw', '', ''].join('\n');
  const voxels = Buffer.from(Array.from({ length: SIDE ** 3 }, (_, i) => i % 251));
  writeFileSync(file, Buffer.concat([Buffer.from(header), voxels]));
}

for (const kind of ['rnode', 'node']) {
  test(`the page works behind /${kind}/HOST/PORT/`, async () => {
    const { port: own, search } = new URL(server.url);
    const prefix = `http://127.0.0.1:${port}/${kind}/localhost/${own}/`;
    const asked = [];
    const { page, context, close } = await openPage(browser, prefix + search);
    page.on('request', request => asked.push(request.url()));
    page.on('websocket', socket => asked.push(socket.url().replace('ws:', 'http:')));

    const turned = await after(page, () => page.getByTestId('stage').press('ArrowLeft'));
    assert.ok(turned.revision > 0);

    const [download] = await Promise.all([page.waitForEvent('download'), (async () => {
      await page.getByTestId('save-menu').click();
      await page.getByTestId('export-format').selectOption('stl');
      await page.getByTestId('export-go').click();
    })()]);
    assert.ok(readFileSync(await download.path()).length > 84);

    const file = path.join(server.folder, `${kind}.nrrd`);
    writeVolume(file);
    await page.keyboard.press('Escape');
    await page.getByTestId('open-panel').click();
    await page.getByTestId('open-files').setInputFiles(file);
    await stateWhen(page, (now, name) => now.volume?.source.endsWith(name) && !now.busy,
                    `${kind}.nrrd`);
    await settled(page);

    // The page loads again by its cookie; the tab has kept the token.
    await page.reload();
    await settled(page);
    assert.ok((await state(page)).volume.source.endsWith(`${kind}.nrrd`));
    // Another tab gets the page, and what is missing.
    const second = await context.newPage();
    second.on('request', request => asked.push(request.url()));
    await second.goto(prefix);
    await second.getByTestId('lost-next').getByText('without the token').waitFor();
    const cookies = await context.cookies();
    const folder = new URL(prefix).pathname.slice(0, -1);
    assert.ok(cookies.some(each => each.path === folder), JSON.stringify(cookies));
    assert.deepEqual(cookies.filter(each => !each.path.startsWith(folder)), []);

    assert.ok(asked.length > 10, asked.join('\n'));
    assert.deepEqual(asked.filter(url => !url.startsWith(prefix) && !url.startsWith('blob:') &&
      !url.startsWith('data:')), []);
    await close();
  });
}
