// Unpacks the files of a ZIP archive in the browser. The layout is that of PKWARE's APPNOTE.TXT
// 6.3.10: a directory at the end says where each file begins.
import {grouped} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** @typedef {import('./upload.js').Named} Named */

/**
 * @typedef {object} Entry  A file of an archive, as its directory says.
 * @property {string} name  With its folders.
 * @property {number} method
 * @property {boolean} isEncrypted
 * @property {number} crc  CRC-32 of the file.
 * @property {number} packedBytes
 * @property {number} bytes
 * @property {number} at  First byte of its local header in the archive.
 */

/** @typedef {{files: number, bytes: number}} Most  Limits of what is unpacked. */

const END = {signature: 0x06054b50, bytes: 22};
const ENTRY = {signature: 0x02014b50, bytes: 46};
const LOCAL = {signature: 0x04034b50, bytes: 30};
const MOST_COMMENT_BYTES = 0xffff;
const LOCATOR_64 = {signature: 0x07064b50, bytes: 20};  // Before the end of a ZIP64 archive.
const COUNT_IN_ZIP64 = 0xffff, IN_ZIP64 = 0xffffffff;   // ZIP64 has such a number elsewhere.
const METHOD = {stored: 0, deflated: 8};
const FLAG = {encrypted: 1, utf8: 0x800};
const PART_BYTES = 16 * 2 ** 20;  // A blob may be on the disk, an array is in memory.
/** The characters 128 to 255 of names that are not UTF-8 (code page 437, APPNOTE.TXT D.1). */
const CODE_PAGE_437 = 'ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐'
  + '└┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u00a0';
const REMEDY = say`Unpack it first, and drop its folder.`;
/** Files of macOS and Windows that belong to no scan. */
const ADDED = /(^|\/)(__MACOSX\/|\.DS_Store$|Thumbs\.db$|desktop\.ini$)/;

/** @param {string} name */
export function isArchive(name) {
  return /\.zip$/i.test(name);
}

/**
 * The files of an archive, in folders below the archive's own name.
 * @param {File} archive
 * @param {Most} most
 * @param {AbortSignal} signal
 * @param {(share: number) => void} progress  Called with the share of unpacked bytes, 0 to 1.
 * @returns {Promise<Named[]>}
 * @throws {Error} with a sentence for the user; or the signal's reason
 */
export async function unzipped(archive, most, signal, progress) {
  if (typeof DecompressionStream !== 'function') {
    throw new Error(say`This browser cannot unpack ${archive.name}. ${REMEDY}`);
  }
  const entries = await entriesOf(archive);
  const total = entries.reduce((sum, {bytes}) => sum + bytes, 0);
  if (entries.length === 0) {
    throw new Error(say`${archive.name} contains no file.`);
  }
  if (entries.length > most.files || total > most.bytes) {
    throw new Error(say`${archive.name} has ${grouped(entries.length)} files with ${grouped(total)}
      bytes; the limits are ${grouped(most.files)} files and ${grouped(most.bytes)} bytes,
      less what was dropped with it.`);
  }
  const folder = archive.name.replace(/\.zip$/i, '');
  const found = [];
  let done = 0;
  const count = (/** @type {number} */ bytes) => {
    done += bytes;
    progress(done / Math.max(total, 1));
  };
  for (const entry of entries) {
    signal.throwIfAborted();
    const file = await unpackedFile(archive, entry, signal, count);
    found.push({file, name: `${folder}/${entry.name}`});
  }
  return found;
}

/**
 * The directory of an archive, without folders and without what systems add.
 * @param {File} archive
 * @returns {Promise<Entry[]>}
 */
async function entriesOf(archive) {
  const tailAt = Math.max(archive.size - END.bytes - MOST_COMMENT_BYTES, 0);
  const tail = await viewOf(archive, tailAt, archive.size);
  const end = placeOfEnd(tail);
  if (end < 0) {
    throw new Error(say`${archive.name} is no ZIP archive, or its end is missing: copy or download
      it again.`);
  }
  const count = tail.getUint16(end + 10, true);
  const [size, offset] = [12, 16].map(byte => tail.getUint32(end + byte, true));
  const locator = end - LOCATOR_64.bytes;
  if (count === COUNT_IN_ZIP64 || size === IN_ZIP64 || offset === IN_ZIP64
    || (locator >= 0 && tail.getUint32(locator, true) === LOCATOR_64.signature)) {
    throw isZip64(archive);
  }
  // Another file may stand before the archive, for example a program that unpacks it.
  const directoryAt = tailAt + end - size, before = directoryAt - offset;
  if (before < 0) {
    throw damaged(archive, '',
      say`The directory would begin ${-before} bytes before the archive.`);
  }
  const view = await viewOf(archive, directoryAt, directoryAt + size);
  /** @type {Map<string, Entry>} */
  const entries = new Map();
  for (let k = 0, at = 0; k < count; ++k) {
    const {entry, bytes} = entryAt(archive, view, at);
    at += bytes;
    if (entry.name.endsWith('/') || ADDED.test(entry.name)) {
      continue;
    }
    if (entries.has(entry.name)) {
      throw new Error(say`${archive.name} has two files with the name ${entry.name}. ${REMEDY}`);
    }
    entries.set(entry.name, {...entry, at: entry.at + before});
  }
  return [...entries.values()];
}

/**
 * The place of the record that ends an archive; -1 if there is none.
 * @param {DataView} tail
 */
function placeOfEnd(tail) {
  for (let at = tail.byteLength - END.bytes; at >= 0; --at) {
    if (tail.getUint32(at, true) === END.signature
      && at + END.bytes + tail.getUint16(at + 20, true) === tail.byteLength) {
      return at;
    }
  }
  return -1;
}

/**
 * @param {File} archive
 * @param {DataView} view  The directory.
 * @param {number} at
 * @returns {{entry: Entry, bytes: number}} with the entry's length in the directory
 */
function entryAt(archive, view, at) {
  if (at + ENTRY.bytes > view.byteLength || view.getUint32(at, true) !== ENTRY.signature) {
    throw damaged(archive, '',
      say`Byte ${at} of the directory's ${view.byteLength} begins no entry.`);
  }
  const short = (/** @type {number} */ byte) => view.getUint16(at + byte, true);
  const long = (/** @type {number} */ byte) => view.getUint32(at + byte, true);
  const nameBytes = short(28), bytes = ENTRY.bytes + nameBytes + short(30) + short(32);
  if (at + bytes > view.byteLength) {
    throw damaged(archive, '', say`An entry ends at byte ${at + bytes} of the directory, which has
      ${view.byteLength}.`);
  }
  const name = new Uint8Array(view.buffer, view.byteOffset + at + ENTRY.bytes, nameBytes);
  const flags = short(8);
  if ([20, 24, 42].some(byte => long(byte) === IN_ZIP64)) {
    throw isZip64(archive);
  }
  return {bytes, entry: {name: textOf(name, (flags & FLAG.utf8) !== 0).replaceAll('\\', '/'),
    isEncrypted: (flags & FLAG.encrypted) !== 0, method: short(10), crc: long(16),
    packedBytes: long(20), bytes: long(24), at: long(42)}};
}

/**
 * @param {Uint8Array} bytes
 * @param {boolean} isUtf8  Whether the archive says so. Many programs write UTF-8 without a flag.
 */
function textOf(bytes, isUtf8) {
  try {
    return new TextDecoder('utf-8', {fatal: !isUtf8}).decode(bytes);
  } catch {
    return Array.from(bytes, byte =>
      byte < 0x80 ? String.fromCharCode(byte) : CODE_PAGE_437[byte - 0x80]).join('');
  }
}

/**
 * @param {File} archive
 * @param {Entry} entry
 * @param {AbortSignal} signal
 * @param {(bytes: number) => void} count  Called with the number of bytes of each unpacked part.
 * @returns {Promise<File>}
 */
async function unpackedFile(archive, entry, signal, count) {
  const {name, method} = entry;
  if (entry.isEncrypted) {
    throw new Error(say`${archive.name} needs a password for ${name}. ${REMEDY}`);
  }
  if (method !== METHOD.stored && method !== METHOD.deflated) {
    throw new Error(say`${archive.name}: ${name} is compressed by method ${method}; only Deflate and
      stored files can be read here. ${REMEDY}`);
  }
  const head = await viewOf(archive, entry.at, entry.at + LOCAL.bytes);
  if (head.byteLength < LOCAL.bytes || head.getUint32(0, true) !== LOCAL.signature) {
    throw damaged(archive, name, say`No file begins at byte ${entry.at} of ${archive.size}.`);
  }
  const begin = entry.at + LOCAL.bytes + head.getUint16(26, true) + head.getUint16(28, true);
  const packed = archive.slice(begin, begin + entry.packedBytes).stream();
  const plain = method === METHOD.stored
    ? packed : packed.pipeThrough(new DecompressionStream('deflate-raw'));
  /** @type {BlobPart[]} */
  let parts = [];
  const reader = plain.getReader();
  let bytes = 0, crc = 0, sinceBlob = 0;
  try {
    for (;;) {
      const part = await reader.read();
      signal.throwIfAborted();
      if (part.done) {
        break;
      }
      bytes += part.value.length;
      if (bytes > entry.bytes) {
        break;  // It is longer than its directory says, and may have no end.
      }
      crc = crcOf(part.value, crc);
      parts.push(part.value);
      sinceBlob += part.value.length;
      if (sinceBlob > PART_BYTES) {
        parts = [new Blob(parts)];
        sinceBlob = 0;
      }
      count(part.value.length);
    }
  } catch (error) {
    throw error instanceof TypeError  // Of the decompressor.
      ? damaged(archive, name, say`Its data cannot be decompressed after ${bytes} of ${entry.bytes}
        bytes.`) : error;
  } finally {
    void reader.cancel().catch(() => {});
  }
  if (bytes !== entry.bytes) {
    throw damaged(archive, name, bytes > entry.bytes
      ? say`It has ${bytes} bytes or more, its directory says ${entry.bytes}.`
      : say`It has ${bytes} bytes, its directory says ${entry.bytes}.`);
  }
  if (crc !== entry.crc) {
    throw damaged(archive, name, say`Its CRC-32 is ${crc.toString(16)}, its directory says
      ${entry.crc.toString(16)}.`);
  }
  return new File(parts, name.replace(/^.*\//, ''));
}

/** @param {File} archive */
function isZip64(archive) {
  return new Error(say`${archive.name} is a ZIP64 archive: it has, or leaves room for, 65,535 files
    or 4 GiB. ${REMEDY}`);
}

/**
 * @param {File} archive
 * @param {string} name  The file in it; empty for the directory.
 * @param {string} fact  What was found, and what was expected: a sentence.
 */
function damaged(archive, name, fact) {
  return new Error(name === ''
    ? say`${archive.name} is damaged: copy or download it again. ${fact}`
    : say`${archive.name} is damaged at ${name}: copy or download it again. ${fact}`);
}

/**
 * @param {Blob} blob
 * @param {number} from
 * @param {number} to
 */
async function viewOf(blob, from, to) {
  return new DataView(await blob.slice(from, to).arrayBuffer());
}

const CRC_TABLE = Uint32Array.from({length: 256}, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; ++bit) {
    crc = crc & 1 ? crc >>> 1 ^ 0xedb88320 : crc >>> 1;
  }
  return crc;
});

/**
 * CRC-32 (ISO 3309) of `bytes` after bytes that have the value `crc`.
 * @param {Uint8Array} bytes
 * @param {number} crc  0 at the beginning.
 */
export function crcOf(bytes, crc) {
  let rest = ~crc;
  for (const byte of bytes) {
    rest = CRC_TABLE[(rest ^ byte) & 0xff] ^ rest >>> 8;
  }
  return ~rest >>> 0;
}
