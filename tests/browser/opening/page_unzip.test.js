// The module that unpacks ZIP archives, without a browser.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { File } from 'node:buffer';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

globalThis.File ??= File;  // Node.js 18 has no global one.
const { crcOf, isArchive, unzipped } =
  await import('../../../host/serve/page/volume/unzip.js');

const MOST = { files: 1000, bytes: 2 ** 30 };
const END_BYTES = 22;  // Of the record that ends an archive.
let folder;

before(() => { folder = mkdtempSync(path.join(tmpdir(), 'pxpl5-test-')); });
after(() => rmSync(folder, { recursive: true, force: true }));

/** The bytes of an archive that Python's zipfile writes: lines of a program after it is open. */
function archiveOf(...lines) {
  const file = path.join(folder, 'made.zip');
  const program = ['import zipfile', `with zipfile.ZipFile(${JSON.stringify(file)}, "w") as z:`,
    ...lines.map(line => `    ${line}`), ''].join('\n');
  execFileSync('python3', ['-W', 'ignore', '-c', program]);
  return readFileSync(file);
}

function unpack(bytes, { most = MOST, signal = new AbortController().signal, name = 'a.zip',
                         progress = () => {} } = {}) {
  return unzipped(new globalThis.File([bytes], name), most, signal, progress);
}

const directoryAt = bytes => bytes.readUInt32LE(bytes.length - END_BYTES + 16);

test('names of archives, and CRC-32 of a known text', () => {
  assert.deepEqual(['a.zip', 'b.ZIP', 'zip', 'a.zip.nrrd'].map(isArchive),
    [true, true, false, false]);
  assert.equal(crcOf(new TextEncoder().encode('123456789'), 0), 0xcbf43926);
});

test('names in UTF-8, in code page 437, and with backslashes', async () => {
  const bytes = archiveOf('z.writestr("a/ü.dcm", b"1")', 'z.writestr("b\\\\c.dcm", b"2")',
    'z.writestr("X.dcm", b"3")');
  const at = bytes.lastIndexOf('X.dcm');
  bytes[at] = 0x81;  // ü, without the flag of UTF-8.
  const found = await unpack(bytes);
  assert.deepEqual(found.map(({ name }) => name), ['a/a/ü.dcm', 'a/b/c.dcm', 'a/ü.dcm']);
  assert.deepEqual(await Promise.all(found.map(({ file }) => file.text())), ['1', '2', '3']);
});

test('progress grows within one file', async () => {
  const shares = [];
  const bytes = archiveOf('z.writestr("a", bytes(3000000), zipfile.ZIP_DEFLATED)');
  const [{ file }] = await unpack(bytes, { progress: share => shares.push(share) });
  assert.equal(file.size, 3000000);
  assert.ok(shares.length > 3 && shares.at(-1) === 1, `${shares}`);
  assert.deepEqual(shares, [...shares].sort((a, b) => a - b));
});

test('a file of more than one part on the disk is whole', async () => {
  const bytes = archiveOf('import random', 'z.writestr("a", random.Random(1).randbytes(20000) * '
    + '2000, zipfile.ZIP_DEFLATED)');
  const [{ file }] = await unpack(bytes);
  assert.equal(file.size, 40000000);  // Its CRC-32 was checked while it was read.
  const whole = new Uint8Array(await file.arrayBuffer());
  assert.equal(crcOf(whole, 0), bytes.readUInt32LE(directoryAt(bytes) + 16));
});

test('numbers of 65,535 bytes are not those of ZIP64', async () => {
  const bytes = archiveOf('z.writestr("a" * 5, bytes(65500))');
  assert.equal(directoryAt(bytes), 65535);
  assert.equal((await unpack(bytes))[0].file.size, 65500);
});

test('ZIP64 is named, wherever it is', async () => {
  const forced = archiveOf('with z.open("a", "w", force_zip64=True) as f: f.write(b"1")');
  const entry = Buffer.from(forced);
  entry.writeUInt32LE(0xffffffff, directoryAt(entry) + 24);
  await assert.rejects(unpack(entry), /a\.zip is a ZIP64 archive/);
  const located = Buffer.concat([forced.subarray(0, -END_BYTES), Buffer.alloc(20),
    forced.subarray(-END_BYTES)]);
  located.writeUInt32LE(0x07064b50, located.length - END_BYTES - 20);
  await assert.rejects(unpack(located), /a\.zip is a ZIP64 archive/);
});

test('two files of one name are refused', async () => {
  const bytes = archiveOf('z.writestr("a", b"1")', 'z.writestr("a", b"2")');
  await assert.rejects(unpack(bytes), /a\.zip has two files with the name a\./);
});

test('limits hold before anything is unpacked', async () => {
  const bytes = archiveOf('z.writestr("a", bytes(1000))', 'z.writestr("b", bytes(1000))');
  for (const most of [{ files: 1, bytes: 9000 }, { files: 9, bytes: 1999 }]) {
    await assert.rejects(unpack(bytes, { most }), /a\.zip has 2 files with 2,000 bytes; the lim/);
  }
  assert.equal((await unpack(bytes, { most: { files: 2, bytes: 2000 } })).length, 2);
});

test('a file that is longer than its directory says is not read to its end', async () => {
  const bytes = archiveOf('z.writestr("a", bytes(200000000), zipfile.ZIP_DEFLATED)');
  bytes.writeUInt32LE(1000, directoryAt(bytes) + 24);
  const Original = globalThis.DecompressionStream;
  let parts = 0;
  globalThis.DecompressionStream = class {
    constructor(format) {
      const { writable, readable } = new Original(format);
      const counted = new TransformStream({ transform(part, controller) {
        parts += 1;
        controller.enqueue(part);
      } });
      Object.assign(this, { writable, readable: readable.pipeThrough(counted) });
    }
  };
  try {
    await assert.rejects(unpack(bytes), /a\.zip is damaged at a: copy or download it again/);
  } finally {
    globalThis.DecompressionStream = Original;
  }
  assert.ok(parts < 20, `${parts} parts were unpacked`);
});

test('a read error is no damage', async () => {
  const bytes = archiveOf('z.writestr("a", bytes(1000))');
  const file = new globalThis.File([bytes], 'a.zip');
  const slice = file.slice.bind(file);
  file.slice = (from, to) => {
    const part = slice(from, to);
    part.stream = () => new ReadableStream({
      pull() { throw new RangeError('the disk is gone'); } });
    return part;
  };
  await assert.rejects(unzipped(file, MOST, new AbortController().signal, () => {}),
    /the disk is gone/);
});
