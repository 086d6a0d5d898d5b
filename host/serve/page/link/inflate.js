// Decompresses bytes that are in memory.

/**
 * A stream of a Blob would come through another process, which takes longer than decompressing.
 * @param {ArrayBuffer | Uint8Array} bytes
 * @param {'deflate' | 'deflate-raw'} format
 * @returns {Promise<ArrayBuffer>}
 * @throws {TypeError} if the bytes are no such data
 */
export async function inflate(bytes, format) {
  const {readable, writable} = new DecompressionStream(format);
  const writer = writable.getWriter();
  const chunk = ArrayBuffer.isView(bytes) ? bytes : new Uint8Array(bytes);
  const written = writer.write(/** @type {any} */ (chunk)).then(() => writer.close());
  const [plain] = await Promise.all([new Response(readable).arrayBuffer(), written]);
  return plain;
}
