// ZIP archives that are dropped or chosen: they open as their folder does, and what is wrong with
// one is said in a sentence and changes nothing.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { writeSeries } from '../dicom.js';
import { browser, byId, openPage, page, server, usePage } from '../harness.js';
import { after, drop, errorsShown, rawSocket, say, state, stateWhen } from '../steps.js';
import { writeEllipsoid } from '../volumes.js';

const METHOD = { stored: 0, deflated: 8, bzip2: 12 };
const END_BYTES = 22;  // Of the record that ends an archive.
const ENCRYPTED_FLAG_AT = 8, CRC_AT = 16;  // In an entry of the directory.

usePage();

const inFolder = name => path.join(server.folder, name);

/** Writes an archive with Python's zipfile: pairs of a name and a file, or a text. */
function writeArchive(name, members, method = METHOD.deflated) {
  const program = 'import sys, json, zipfile\n'
    + 'out, method, members = json.load(sys.stdin)\n'
    + 'with zipfile.ZipFile(out, "w", method) as archive:\n'
    + '    for name, file in members:\n'
    + '        data = open(file, "rb").read() if file else b"junk"\n'
    + '        archive.writestr(name, data, method)\n';
  execFileSync('python3', ['-c', program],
    { input: JSON.stringify([inFolder(name), method, members]) });
  return inFolder(name);
}

/** Writes what `change` makes of an archive's bytes. */
function writeChanged(name, archive, change) {
  const bytes = readFileSync(archive);
  writeFileSync(inFolder(name), change(bytes) ?? bytes);
  return inFolder(name);
}

/** A scan of `side` slices, and as an archive with what macOS adds. */
function writeScan(name, side) {
  const files = writeSeries(inFolder(name), [{ description: 'Hip', side }]);
  const members = files.map(file => [`Müller/hip\\${path.basename(file)}`, file]);
  const added = [['__MACOSX/Müller/._0-0.dcm', ''], ['Müller/.DS_Store', '']];
  return writeArchive(`${name}.zip`, [...members, ...added]);
}

const writeBall = () => writeEllipsoid(inFolder('ball.nrrd'), [16, 16, 16], [6, 6, 6]);

/** Drops a file and returns the digest of the volume that it opens. */
async function digestOf(file, source) {
  const { digest } = await after(page, () => drop(page, [file]),
    (now, wanted) => now.volume?.source.includes(wanted) && !now.busy, source);
  return digest;
}

test('an archive of a DICOM folder opens as the folder does', async () => {
  const archive = writeScan('hip', 10);
  const plain = await digestOf(inFolder('hip'), 'hip');
  const { volume } = await state(page);
  await digestOf(writeArchive('ball.zip', [['ball.nrrd', writeBall()]]), 'ball.nrrd');
  const unpacked = await digestOf(archive, 'hip/Müller/hip');
  assert.equal(unpacked, plain);
  assert.deepEqual((await state(page)).volume.size, volume.size);
  assert.deepEqual(await errorsShown(page), []);
});

test('an archive on the server opens by its path, as its folder does', async () => {
  const archive = writeScan('knee-far', 7);
  const raw = await rawSocket(page, server.url);
  const digests = [];
  for (const source of [inFolder('knee-far'), archive]) {
    const reply = await say(raw, `load ${source}`);
    assert.ok(reply.ok, reply.error);
    digests.push((await say(raw, 'digest')).result);
  }
  await raw.evaluate(({ socket }) => socket.close());
  assert.deepEqual(digests[1], digests[0]);
  const { volume } = await stateWhen(
    page, (now, source) => now.volume?.source === source && !now.busy, archive);
  assert.equal(volume.name, 'knee-far');
  assert.deepEqual(await errorsShown(page), []);
});

test('stored files, several archives, and bytes before an archive', async () => {
  const stored = writeArchive('stored.zip', [['a/ball.nrrd', writeBall()]], METHOD.stored);
  const digest = await digestOf(stored, 'ball.nrrd');
  const behind = writeChanged('behind.ZIP', stored, bytes =>
    Buffer.concat([Buffer.from('#!/bin/sh\n'), bytes]));
  await byId('open-panel').click();
  await byId('phantom-torus').click();
  await stateWhen(page, now => now.volume?.source === 'phantom:torus' && !now.busy);
  await byId('open-panel').click();
  const again = await after(page, () => byId('open-files').setInputFiles(behind),
    now => now.volume?.source.includes('ball.nrrd') && !now.busy);
  assert.equal(again.digest, digest);

  const files = writeSeries(inFolder('knee'), [{ description: 'Knee', side: 9 }]);
  const halves = [files.slice(0, 4), files.slice(4)].map((half, index) =>
    writeArchive(`knee${index}.zip`, half.map(file => [path.basename(file), file])));
  await drop(page, halves);
  await stateWhen(page, now => now.volume?.size[2] === 9 && !now.busy);
});

test('what is wrong with an archive is said, and the volume stays', async () => {
  const good = writeScan('wrong', 8);
  const before = await state(page);
  const directoryAt = bytes => bytes.readUInt32LE(bytes.length - END_BYTES + 16);
  const cases = [
    [writeChanged('cut.zip', good, bytes => bytes.subarray(0, 900)), /no ZIP archive, or its end/],
    [writeChanged('bad.zip', good, bytes => { bytes[60] ^= 1; }), /bad\.zip is damaged at Müller/],
    [writeChanged('directory.zip', good, bytes => { bytes[directoryAt(bytes)] ^= 1; }),
     /directory\.zip is damaged: copy/],
    [writeChanged('sum.zip', good, bytes => { bytes[directoryAt(bytes) + CRC_AT] ^= 1; }),
     /sum\.zip is damaged at Müller/],
    [writeChanged('longer.zip', good, bytes => {
      bytes.writeUInt32LE(9, directoryAt(bytes) + 24);  // The file has more than it says.
    }), /longer\.zip is damaged at Müller/],
    [writeChanged('locked.zip', good, bytes => {
      bytes[directoryAt(bytes) + ENCRYPTED_FLAG_AT] |= 1;
    }), /locked\.zip needs a password for Müller.*drop its folder/],
    [writeChanged('wide.zip', good, bytes => {
      bytes.writeUInt16LE(0xffff, bytes.length - END_BYTES + 10);
    }), /wide\.zip is a ZIP64 archive/],
    [writeArchive('other.zip', [['ball.nrrd', writeBall()]], METHOD.bzip2),
     /ball\.nrrd is compressed by method 12; only Deflate/],
    [writeArchive('empty.zip', []), /empty\.zip contains no file/],
    [writeChanged('bomb.zip', good, bytes => {
      bytes.writeUInt32LE(0xfffffffe, directoryAt(bytes) + 24);
      const second = directoryAt(bytes) + 46 + bytes.readUInt16LE(directoryAt(bytes) + 28);
      bytes.writeUInt32LE(0xfffffffe, second + 24);
    }), /bomb\.zip has 8 files with 8,.* bytes; the limits are 100,000 files and 4,294,967,296/],
  ];
  for (const [file, sentence] of cases) {
    await drop(page, [file]);
    await page.getByTestId('toast-error').waitFor();
    assert.match((await errorsShown(page)).join(' '), sentence);
    await page.getByTestId('toast-error').getByRole('button').click();
    await page.getByTestId('uploading').waitFor({ state: 'detached' });
  }
  const now = await state(page);
  assert.deepEqual([now.volume.source, now.revision], [before.volume.source, before.revision]);
});

/** In the page: parts of files are unpacked once `release()` is called. */
function holdUnpacking() {
  const Original = globalThis.DecompressionStream;
  const gate = new Promise(open => {
    globalThis.release = () => {
      globalThis.DecompressionStream = Original;
      open();
    };
  });
  globalThis.DecompressionStream = class {
    constructor(format) {
      const { writable, readable } = new Original(format);
      const held = new TransformStream({ transform: async (part, controller) => {
        await gate;
        controller.enqueue(part);
      } });
      this.writable = writable;
      this.readable = readable.pipeThrough(held);
    }
  };
}

test('unpacking can be canceled', async () => {
  const archive = writeArchive('canceled.zip', [['one/ball.nrrd', writeBall()]]);
  const before = await state(page);
  const uploads = [];
  page.on('request', request => request.url().includes('/upload/') && uploads.push(request.url()));
  await page.evaluate(holdUnpacking);
  await drop(page, [archive]);
  const box = page.getByTestId('uploading');
  await box.getByText('Unpacking canceled.zip').waitFor();
  await box.getByRole('button', { name: 'Cancel' }).click();
  await page.evaluate(() => globalThis.release());
  await box.waitFor({ state: 'detached' });
  await page.evaluate(() => new Promise(drawn =>
    requestAnimationFrame(() => requestAnimationFrame(drawn))));
  assert.deepEqual(uploads, []);
  assert.deepEqual(await errorsShown(page), []);
  assert.equal((await state(page)).volume.source, before.volume.source);
});

test('an archive inside of a folder stays as it is', async () => {
  const before = await state(page);
  writeSeries(inFolder('with'), [{ description: 'Hip', side: 6 }]);
  writeFileSync(path.join(inFolder('with'), 'extra.zip'), 'no archive');
  await drop(page, [inFolder('with')]);
  await stateWhen(page, now => now.volume?.size[2] === 6 && !now.busy);
  assert.notEqual((await state(page)).volume.source, before.volume.source);
  assert.deepEqual(await errorsShown(page), []);
});

/** In the page: `globalThis.dropped` resolves after the page has taken a dropped file. */
function watchDroppedFile() {
  const { webkitGetAsEntry } = DataTransferItem.prototype;
  globalThis.dropped = new Promise(resolve => {
    DataTransferItem.prototype.webkitGetAsEntry = function () {
      const entry = webkitGetAsEntry.call(this), { file } = entry;
      entry.file = (take, fail) => file.call(entry, found => {
        take(found);
        setTimeout(resolve);  // After all that the page does with it at once.
      }, fail);
      return entry;
    };
  });
}

test('a page that only watches unpacks nothing', async () => {
  const watcher = await openPage(browser, server.watchUrl);
  await watcher.page.evaluate(watchDroppedFile);
  await watcher.page.evaluate(holdUnpacking);  // Else its progress may be gone already.
  await drop(watcher.page, [writeScan('seen', 5)]);
  await watcher.page.evaluate(() => globalThis.dropped);
  assert.equal(await watcher.page.getByTestId('uploading').count(), 0);
  assert.deepEqual(await errorsShown(watcher.page), []);
  await watcher.close();
});
