// Texts in PNG files: what the machine wrote about a picture goes into the marked copy, too.

const SIGNATURE_BYTES = 8;
const HEADER_BYTES = SIGNATURE_BYTES + 25;  // The first chunk, IHDR, has 13 bytes of data.
const TEXTS = ['tEXt', 'zTXt', 'iTXt'];

/**
 * @param {Uint8Array} file  A PNG.
 * @returns {Uint8Array[]}   Its text chunks, whole.
 */
function textChunks(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const found = [];
  for (let at = SIGNATURE_BYTES; at + 12 <= file.length;) {
    const end = at + 12 + view.getUint32(at);  // Length, type, data, checksum.
    const type = String.fromCharCode(...file.subarray(at + 4, at + 8));
    if (TEXTS.includes(type) && end <= file.length) {
      found.push(file.slice(at, end));
    }
    at = end;
  }
  return found;
}

/**
 * The picture with the texts of another one.
 * @param {Blob} picture  A PNG.
 * @param {Blob} source   The PNG that has the texts.
 * @returns {Promise<Blob>}
 */
export async function withTexts(picture, source) {
  const texts = textChunks(new Uint8Array(await source.arrayBuffer()));
  return new Blob([picture.slice(0, HEADER_BYTES), .../** @type {any[]} */ (texts),
    picture.slice(HEADER_BYTES)], {type: 'image/png'});
}
