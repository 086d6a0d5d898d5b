// Binary messages of the server, taken apart. Pure functions; layout: host/serve/README.md.

/** @typedef {import('./types.js').FrameHeader} FrameHeader */

export const FRAME_MAGIC = 0x46523550;
export const ANSWER_MAGIC = 0x4e413550;
const FRAME_HEADER_BYTES = 32;
const ANSWER_HEADER_BYTES = 16;
const KINDS = new Map([[1, 'jpeg'], [2, 'png']]);

/**
 * What the first four bytes say that a message is; 0 if it is shorter.
 * @param {ArrayBuffer} message
 */
export function magicOf(message) {
  return message.byteLength < 4 ? 0 : new DataView(message).getUint32(0, true);
}

/**
 * A frame's header and its encoded picture, which shares the message's memory.
 * @param {ArrayBuffer} message
 * @returns {{header: FrameHeader, picture: Uint8Array}}
 * @throws {Error} if the message is too short or names no kind of picture
 */
export function parseFrame(message) {
  if (message.byteLength < FRAME_HEADER_BYTES) {
    throw new Error(`frame: ${message.byteLength} bytes, its header has ${FRAME_HEADER_BYTES}`);
  }
  const view = new DataView(message);
  const kind = KINDS.get(view.getUint8(16));
  if (kind === undefined) {
    throw new Error(`frame: kind ${view.getUint8(16)} is neither JPEG (1) nor PNG (2)`);
  }
  const flags = view.getUint8(19);
  const digest = view.getBigUint64(24, true);
  const header = {
    number: view.getUint32(4, true),
    revision: view.getUint32(8, true),
    width: view.getUint16(12, true),
    height: view.getUint16(14, true),
    kind: /** @type {'jpeg' | 'png'} */ (kind),
    quality: view.getUint8(17),
    samples: view.getUint8(18),
    rests: (flags & 1) !== 0,
    last: (flags & 2) !== 0,
    machine_ms: view.getFloat32(20, true),
    digest: digest === 0n ? '' : digest.toString(16).padStart(16, '0'),
  };
  return {header, picture: new Uint8Array(message, FRAME_HEADER_BYTES)};
}

/**
 * A binary answer: its id, its JSON and a copy of the bytes that follow.
 * @param {ArrayBuffer} message
 * @returns {{id: number, json: any, bytes: ArrayBuffer}}
 * @throws {Error} if the message is shorter than it says
 */
export function parseAnswer(message) {
  if (message.byteLength < ANSWER_HEADER_BYTES) {
    throw new Error(`answer: ${message.byteLength} bytes, its header has ${ANSWER_HEADER_BYTES}`);
  }
  const view = new DataView(message);
  const jsonBytes = view.getUint32(8, true);
  const end = ANSWER_HEADER_BYTES + jsonBytes;
  if (end > message.byteLength) {
    throw new Error(`answer: ${message.byteLength} bytes, its JSON ends at ${end}`);
  }
  const text = new TextDecoder().decode(new Uint8Array(message, ANSWER_HEADER_BYTES, jsonBytes));
  const first = Math.ceil(end / 8) * 8;
  return {id: view.getUint32(4, true), json: JSON.parse(text), bytes: message.slice(first)};
}
