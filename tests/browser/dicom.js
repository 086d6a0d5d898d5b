// Writes small DICOM files: a ball in slices, as many series as wanted.
import { mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

const EXPLICIT_LITTLE = '1.2.840.10008.1.2.1';
const CT_STORAGE = '1.2.840.10008.5.1.4.1.1.2';
const LONG = new Set(['OW', 'SQ']);  // Their length has four bytes.

/** One element; `value` is a text or a Buffer. */
export function element(group, number, vr, value) {
  let bytes = typeof value === 'string' ? Buffer.from(value) : value;
  if (bytes.length % 2) bytes = Buffer.concat([bytes, Buffer.from(vr === 'UI' ? '\0' : ' ')]);
  const head = Buffer.alloc(LONG.has(vr) ? 12 : 8);
  head.writeUInt16LE(group, 0);
  head.writeUInt16LE(number, 2);
  head.write(vr, 4);
  if (LONG.has(vr)) head.writeUInt32LE(bytes.length, 8);
  else head.writeUInt16LE(bytes.length, 6);
  return Buffer.concat([head, bytes]);
}

/** A sequence of one item. */
export function sequence(group, number, elements) {
  const content = Buffer.concat(elements), head = Buffer.alloc(8);
  head.writeUInt16LE(0xfffe, 0);
  head.writeUInt16LE(0xe000, 2);
  head.writeUInt32LE(content.length, 4);
  return element(group, number, 'SQ', Buffer.concat([head, content]));
}

/** The number by which the elements of a file ascend. */
function tagOf(bytes) {
  return bytes.readUInt16LE(0) * 0x10000 + bytes.readUInt16LE(2);
}

function short(value) {
  const bytes = Buffer.alloc(2);
  bytes.writeUInt16LE(value);
  return bytes;
}

/** A slice of a ball of 400 HU. */
function slice({ uid, number, description, modality, shift_mm, side, z, patient, study,
                bodyPart, elements = [] }) {
  const pixels = Buffer.alloc(2 * side * side);
  for (let at = 0; at < side * side; at++) {
    const place = [at % side, Math.floor(at / side), z].map(each => each - (side - 1) / 2);
    pixels.writeInt16LE(Math.hypot(...place) < side / 3 ? 400 : -1000, 2 * at);
  }
  const syntax = element(0x0002, 0x0010, 'UI', EXPLICIT_LITTLE);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(syntax.length);
  return Buffer.concat([
    Buffer.alloc(128), Buffer.from('DICM'), element(0x0002, 0x0000, 'UL', length), syntax, ...[
    element(0x0008, 0x0016, 'UI', CT_STORAGE),
    element(0x0008, 0x0018, 'UI', `${uid}.${z + 1}`),
    element(0x0008, 0x0060, 'CS', modality),
    ...study ? [element(0x0008, 0x1030, 'LO', study)] : [],
    element(0x0008, 0x103e, 'LO', description),
    ...patient ? [element(0x0010, 0x0010, 'PN', patient)] : [],
    ...bodyPart ? [element(0x0018, 0x0015, 'CS', bodyPart)] : [],
    element(0x0020, 0x000d, 'UI', study ? `1.2.3.9.${study.length}` : '1.2.3'),
    element(0x0020, 0x000e, 'UI', uid),
    element(0x0020, 0x0011, 'IS', String(number)),
    element(0x0020, 0x0013, 'IS', String(z + 1)),
    element(0x0020, 0x0032, 'DS', `0\\${(shift_mm * z).toFixed(6)}\\${z}`),
    element(0x0020, 0x0037, 'DS', '1\\0\\0\\0\\1\\0'),
    element(0x0028, 0x0002, 'US', short(1)),
    element(0x0028, 0x0004, 'CS', 'MONOCHROME2'),
    element(0x0028, 0x0010, 'US', short(side)),
    element(0x0028, 0x0011, 'US', short(side)),
    element(0x0028, 0x0030, 'DS', '1\\1'),
    element(0x0028, 0x0100, 'US', short(16)),
    element(0x0028, 0x0101, 'US', short(16)),
    element(0x0028, 0x0102, 'US', short(15)),
    element(0x0028, 0x0103, 'US', short(1)),
    element(0x0028, 0x1052, 'DS', '0'),
    element(0x0028, 0x1053, 'DS', '1'),
    element(0x7fe0, 0x0010, 'OW', pixels), ...elements].sort((a, b) => tagOf(a) - tagOf(b))]);
}

/**
 * Writes a folder of series, a file for each slice.
 * @param {{description: string, side: number, modality?: string, shift_mm?: number,
 *   patient?: string, study?: string, bodyPart?: string,
 *   elements?: Buffer[]}[]} series
 *   with as many slices as pixels aside; `shift_mm` moves each slice to posterior, as a tilted
 *   gantry does; `elements` are further ones of each slice
 * @returns {string[]} the files
 */
export function writeSeries(folder, series) {
  mkdirSync(folder, { recursive: true });
  return series.flatMap(({ description, side, modality = 'CT', shift_mm = 0, ...rest }, index) =>
    Array.from({ length: side }, (_, z) => {
      const file = path.join(folder, `${index}-${z}.dcm`);
      writeFileSync(file, slice({ uid: `1.2.3.${index + 1}`, number: index + 1, description,
        modality, shift_mm, side, z, ...rest }));
      return file;
    }));
}
