// Binary messages of the server, taken apart. Pure functions; layout: host/serve/page_schema.fbs.

import {say} from '../texts/say.js';
import {ANSWER_HEADER_BYTES, ANSWER_HEADER_MAGIC, FRAME_FLAG, FRAME_HEADER_BYTES,
  FRAME_HEADER_MAGIC, PICTURE_KIND, readAnswerHeader, readFrameHeader} from './vocabulary.js';

/** @typedef {import('./types.js').FrameHeader} FrameHeader */

/** @typedef {keyof typeof PICTURE_KIND} PictureKind */
/** @type {Map<number, PictureKind>} */
const KINDS = new Map([[PICTURE_KIND.jpeg, 'jpeg'], [PICTURE_KIND.png, 'png'],
  [PICTURE_KIND.vp8, 'vp8']]);

const RELOAD = say`Load the page again; it may be older than the server.`;

/**
 * The magic number in the first four bytes of a message; 0 if the message is shorter.
 * @param {ArrayBuffer} message
 */
function magicOf(message) {
  return message.byteLength < 4 ? 0 : new DataView(message).getUint32(0, true);
}

/**
 * A frame or an answer.
 * @param {ArrayBuffer} message
 * @throws {Error} with a sentence, if the message is neither, or is not whole
 */
export function parseMessage(message) {
  switch (magicOf(message)) {
    case FRAME_HEADER_MAGIC:
      return parseFrame(message);
    case ANSWER_HEADER_MAGIC:
      return parseAnswer(message);
    default:
      throw new Error(say`Message: ${message.byteLength} bytes, neither a frame nor an answer.
        ${RELOAD}`);
  }
}

/**
 * A frame's header, its encoded pictures and the packed depths of each picture, if there are any.
 * They share the message's memory.
 * @param {ArrayBuffer} message
 * @returns {{header: FrameHeader, picture: Uint8Array, depths: Uint8Array[]}}
 * @throws {Error} if the message has another length than it says, or names no kind of picture
 */
export function parseFrame(message) {
  if (message.byteLength < FRAME_HEADER_BYTES) {
    throw new Error(say`Frame: ${message.byteLength} bytes, its header has
      ${FRAME_HEADER_BYTES}. ${RELOAD}`);
  }
  const view = new DataView(message);
  const {flags, kind, digest, picture_bytes, depth_bytes, ...rest} = readFrameHeader(view);
  const end = FRAME_HEADER_BYTES + picture_bytes + depth_bytes;
  if (message.byteLength !== end) {
    throw new Error(say`Frame: ${message.byteLength} bytes, its picture and depths end at
      ${end}. ${RELOAD}`);
  }
  const name = KINDS.get(kind);
  if (!name) {
    throw new Error(say`Frame: kind ${kind} is none of JPEG (1), PNG (2) and VP8 (3). ${RELOAD}`);
  }
  const header = {
    ...rest,
    kind: name,
    rests: (flags & FRAME_FLAG.rests) !== 0,
    last: (flags & FRAME_FLAG.last) !== 0,
    key: (flags & FRAME_FLAG.key) !== 0,
    fullColor: (flags & FRAME_FLAG.full_color) !== 0,
    digest: digest === 0n ? '' : digest.toString(16).padStart(16, '0'),
  };
  /** @type {Uint8Array[]} */
  const depths = [];
  for (let at = end - depth_bytes; at < end;) {
    const first = at + 4, bytes = first > end ? 0 : view.getUint32(at, true);
    if (first + bytes > end) {
      throw new Error(say`Frame: the depths of picture ${depths.length + 1} end at byte
        ${first + bytes}, but the frame has ${end} bytes. ${RELOAD}`);
    }
    depths.push(new Uint8Array(message, first, bytes));
    at = first + bytes;
  }
  return {header, picture: new Uint8Array(message, FRAME_HEADER_BYTES, picture_bytes), depths};
}

/**
 * A binary answer: its id, its JSON and a copy of the bytes that follow.
 * @param {ArrayBuffer} message
 * @returns {{id: number, json: any, bytes: ArrayBuffer}}
 * @throws {Error} if the message is shorter than it says
 */
export function parseAnswer(message) {
  if (message.byteLength < ANSWER_HEADER_BYTES) {
    throw new Error(say`Answer: ${message.byteLength} bytes, its header has
      ${ANSWER_HEADER_BYTES}. ${RELOAD}`);
  }
  const {id, json_bytes: jsonBytes} = readAnswerHeader(new DataView(message));
  const end = ANSWER_HEADER_BYTES + jsonBytes;
  if (end > message.byteLength) {
    throw new Error(say`Answer: ${message.byteLength} bytes, its JSON ends at ${end}.
      ${RELOAD}`);
  }
  const text = new TextDecoder().decode(new Uint8Array(message, ANSWER_HEADER_BYTES, jsonBytes));
  const first = Math.ceil(end / 8) * 8;
  return {id, json: JSON.parse(text), bytes: message.slice(first)};
}
