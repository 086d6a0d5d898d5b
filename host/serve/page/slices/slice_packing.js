// Slices that the server has packed for a slow link (host/serve/director/slice_packing.hpp).
import {inflate} from '../link/inflate.js';
import {say} from '../texts/say.js';
import {ARRAYS} from './slice_pixels.js';

/** @typedef {{json: any, bytes: ArrayBuffer}} Answer  To `ask slice`. */

/**
 * An answer as it was before it was packed, if it was.
 * @param {Answer} answer
 * @returns {Promise<Answer>}
 * @throws {Error} if its bytes are no slice of its size
 */
export async function unpacked({json, bytes}) {
  if (!json.packed) {
    return {json, bytes};
  }
  const plain = await inflate(bytes, 'deflate');
  const count = json.width * json.height, each = ARRAYS[json.type]?.BYTES_PER_ELEMENT ?? 0;
  if (plain.byteLength !== json.packed.bytes) {
    throw new Error(say`slice: ${plain.byteLength} bytes were packed, its description says
      ${json.packed.bytes}`);
  }
  if (plain.byteLength < count * each) {
    throw new Error(say`slice: ${plain.byteLength} bytes were packed, ${json.width} x
      ${json.height} values of ${json.type} have ${count * each}`);
  }
  const planes = new Uint8Array(plain.slice(0, count * each));
  const values = new Uint8Array(plain, 0, count * each);
  for (let k = 0, value = 0; k < count; ++k) {
    let difference = 0;
    for (let plane = 0; plane < each; ++plane) {
      difference |= planes[plane * count + k] << 8 * plane;
    }
    value = value + difference | 0;
    for (let plane = 0; plane < each; ++plane) {
      values[k * each + plane] = value >>> 8 * plane;
    }
  }
  return {json, bytes: plain};
}

/** Whether this browser can unpack slices. */
export const CAN_UNPACK = typeof DecompressionStream === 'function';
