// The series of a folder: by patient and study, with thumbnails that the io process has made.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { writeSeries } from '../dicom.js';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { ask, drop, errorsShown, rawSocket, stateWhen } from '../steps.js';

usePage();

const SERIES = [{ description: 'Thorax 5 mm', side: 10, patient: 'Doe^Jane', study: 'Chest' },
  { description: 'Thorax 1 mm', side: 14, patient: 'Doe^Jane', study: 'Chest' },
  { description: 'Knee', side: 12, modality: 'MR', patient: 'Doe^Jane', study: 'Left knee' },
  { description: '<b>Hip</b>', side: 11, patient: 'Roe^Rick' }];

/** Opens a folder on the server's computer by its path. */
async function openPath(folder) {
  await byId('open-panel').click();
  await byId('open-path').fill(folder);
  await byId('open-go').click();
}

/** In the page: the gray of the middle and of a corner of a canvas. */
function grays(canvas) {
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  return { width, height, corner: data[0],
           middle: data[4 * (width * Math.floor(height / 2) + Math.floor(width / 2))] };
}

/** The file with pixels that are no RLE, although it says so. */
function compressed(file) {
  const text = readFileSync(file, 'latin1').replace('1.2.840.10008.1.2.1', '1.2.840.10008.1.2.5');
  const pixels = text.lastIndexOf('\xe0\x7f\x10\x00OW');
  const item = '\xfe\xff\x00\xe0', end = '\xfe\xff\xdd\xe0';
  return Buffer.from(`${text.slice(0, pixels)}\xe0\x7f\x10\x00OB\0\0\xff\xff\xff\xff`
    + `${item}\0\0\0\0${item}\x10\0\0\0${'no RLE'.padEnd(16, '.')}${end}\0\0\0\0`, 'latin1');
}

test('series are listed by patient and study with the middle slice; a click opens', async () => {
  const folder = path.join(server.folder, 'disc');
  writeSeries(folder, SERIES);
  await openPath(folder);
  await byId('patient').first().waitFor();
  assert.deepEqual(await byId('patient').locator('h3').allTextContents(), ['Doe, Jane',
    'Roe, Rick']);
  assert.deepEqual(await byId('patient').first().locator('h4').allTextContents(),
                   ['Chest', 'Left knee']);
  assert.equal(await byId('thumbnail').count(), 4);
  assert.match(await byId('series-2').innerText(), /Thorax 1 mm\s+CT, 14 × 14 × 14, \d+ kB/);
  assert.match(await byId('series-4').innerText(), /<b>Hip<\/b>/);
  const shown = await byId('series-2').getByTestId('thumbnail').evaluate(grays);
  assert.deepEqual(shown, { width: 14, height: 14, corner: 0, middle: 255 });
  await shoot(page, 'open-series');
  await byId('series-2').click();
  await stateWhen(page, now => now.volume?.size[2] === 14 && !now.busy);
  await byId('open').waitFor({ state: 'hidden' });
});

test('a dropped folder of several series has the same list', async () => {
  const folder = path.join(server.folder, 'dropped');
  writeSeries(path.join(folder, 'a', 'b'), SERIES.slice(0, 2));
  await drop(page, [folder]);
  await byId('thumbnail').nth(1).waitFor();
  await byId('series-1').click();
  await stateWhen(page, now => now.volume?.size[2] === 10 && !now.busy);
  assert.deepEqual(await errorsShown(page), []);
});

test('a series whose middle slice is broken has no thumbnail, and the others have theirs',
     async () => {
  const folder = path.join(server.folder, 'broken');
  const files = writeSeries(folder, SERIES.slice(0, 2));
  const raw = await rawSocket(page, server.url);
  // All pixels of the first series are said to be compressed, and are not.
  for (const file of files.slice(0, 10)) writeFileSync(file, compressed(file));
  const { json, bytes } = await ask(raw, { ask: 'series', path: folder });
  assert.deepEqual(json.series.map(({ number, slices }) => [number, slices]), [[1, 10], [2, 14]]);
  assert.deepEqual(json.series[1].thumbnail, { first: 0, height: 14, width: 14 });
  assert.equal(json.series[0].thumbnail, undefined);
  assert.ok(bytes.length >= 14 * 14);
  await openPath(folder);
  await byId('no-thumbnail').waitFor();
  assert.match(await byId('series-note').innerText(), /No thumbnail for 1 of 2 series/);
  await page.keyboard.press('Escape');
});

test('only allowed folders are looked through', async () => {
  const raw = await rawSocket(page, server.url);
  await assert.rejects(ask(raw, { ask: 'series', path: '/etc' }), /outside of the folders/);
  await assert.rejects(ask(raw, { ask: 'series', path: `${server.folder}/../..` }),
                       /outside of the folders/);
  await assert.rejects(ask(raw, { ask: 'series', path: 'disc' }), /must be a path from \//);
});
