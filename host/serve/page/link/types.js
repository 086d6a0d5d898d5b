// Types of the page. vocabulary.js has the types of the server's frame header and state.

/** @typedef {[number, number, number]} Triple   Patient coordinates in millimeters, LPS. */

/**
 * @typedef {object} Reply
 * @property {boolean} ok
 * @property {string} [text]
 * @property {any} [result]             The command's fields.
 * @property {number} [ms]
 * @property {number} [revision]        Of the state that the command led to.
 * @property {string} [error]           A sentence.
 * @property {boolean} [isOwn]          The error is the page's own, in the language of the page.
 *                                      All others are the machine's, in English.
 * @property {boolean} [superseded]     A newer setting took its place.
 */

/**
 * A command of the server: see `descriptor_fields` in host/base/command_descriptor.hpp.
 * @typedef {object} CommandDescriptor
 * @property {string} name
 * @property {'question' | 'setting' | 'action' | 'memory'} kind
 * @property {number} subject_words     Number of words that name the subject of a setting.
 * @property {{type: string}[]} words
 */

/**
 * @typedef {{version: string, role: 'driver' | 'watcher', viewer: number, topology: string,
 *   class_port: number, commands: CommandDescriptor[]}} Hello
 */
/** @typedef {{what: string, done: number, total: number}} Progress */
/** @typedef {{level: 'info' | 'error', text: string}} Note */
/** @typedef {{json: any, bytes: ArrayBuffer}} Answer */

/**
 * A frame's header as parseFrame returns it. The digest has 16 hexadecimal digits, '' while moving.
 * @typedef {Omit<ReturnType<import('./vocabulary.js').readFrameHeader>, 'kind' | 'flags' | 'digest'
 *   | 'picture_bytes' | 'depth_bytes'>
 *   & {kind: 'jpeg' | 'png' | 'vp8', rests: boolean, last: boolean, key: boolean,
 *     fullColor: boolean, digest: string}} FrameHeader
 */

/** @typedef {{color: string, text: string}} LegendLine  color: of the square, '' for none. */
/** @typedef {{name: string, script: string}} Session   A file: its name and its contents. */

export {};
