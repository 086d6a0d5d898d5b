// The work of one pixel processor: A x + B y + C of an instruction, checked against the machine.

/** @typedef {import('../inspect/why_cards.js').Write} Write */
/** @typedef {import('../inspect/why_cards.js').Visit} Visit */

/**
 * The depth at one pixel, computed from the instruction that wrote it.
 * @typedef {object} Depth
 * @property {number} at        Executed instructions before it.
 * @property {string} instruction
 * @property {bigint[]} terms   A, B and C.
 * @property {bigint} sum       A x + B y + C.
 * @property {number} bits      Of the field.
 * @property {number} shift     The lowest bits of the sum that are left out.
 * @property {number} z         The field after the instruction.
 */

const TREE = /^TREEintoMEM m\d+:(\d+)(?: >>(\d+))?\s+(-?\d+) (-?\d+) (-?\d+)$/;

/**
 * The instruction of a triangle that wrote the depth. null if there is no such instruction, or if
 * the result differs from the depth that the machine has: then this is not how it was computed.
 * @param {Visit} visit
 * @param {{x: number, y: number}} place  Of the pixel in its region.
 * @returns {Depth | null}
 */
export function depthOf({writes}, {x, y}) {
  const write = writes.find(({before, after}) => before.z !== after.z);
  const found = write && TREE.exec(write.instruction);
  if (!found) {
    return null;
  }
  const [bits, shift] = [Number(found[1]), Number(found[2] ?? 0)];
  const terms = found.slice(3).map(BigInt);
  const sum = terms[0] * BigInt(x) + terms[1] * BigInt(y) + terms[2];
  const z = Number(BigInt.asUintN(bits, sum >> BigInt(shift)));
  return z === write.after.z
    ? {at: write.at, instruction: write.instruction, terms, sum, bits, shift, z} : null;
}
