// Actions of tests on a page. No function waits for a time. All wait for the page's own figures in
// window.pxpl5 (host/serve/page/picture/metrics.js).
import { readFile } from 'node:fs/promises';

/** The state that the page was told last. */
export function state(page) {
  return page.evaluate(() => globalThis.pxpl5.state);
}

/**
 * Waits until the state is as wanted, and returns it.
 * @param {(state: object, wanted: any) => boolean} holds runs in the page
 */
export async function stateWhen(page, holds, wanted) {
  // A function made here: the page's policy forbids to make one from text there.
  await page.waitForFunction(new Function('wanted', `const { state } = globalThis.pxpl5 ?? {};
    return state && (${holds})(state, wanted);`), wanted);
  return state(page);
}

/**
 * Waits until the newest state is on the screen, lossless and refined to the end.
 * @returns {Promise<{revision: number, digest: string, samples: number, frames: number}>}
 */
export async function settled(page) {
  const shown = await page.waitForFunction(() => {
    const { state, revision, rests, last, digest, samples, frames } = globalThis.pxpl5 ?? {};
    const whole = state && !state.busy && revision === state.revision && rests && last;
    return whole && { revision, digest, samples, frames };
  });
  return shown.jsonValue();
}

/**
 * Does something and waits until a newer state, as wanted if that is said, has settled.
 * @param {(state: object, wanted: any) => boolean} [holds] runs in the page
 * @returns {Promise<{state: object, digest: string, revision: number}>}
 */
export async function after(page, act, holds = () => true, wanted = null) {
  const before = (await state(page)).revision;
  await act();
  await stateWhen(page, (now, was) => now.revision > was, before);
  await stateWhen(page, holds, wanted);
  const shown = await settled(page);
  return { ...shown, state: await state(page) };
}

/** A raw socket, after it has hidden the skin of the pelvis, which is transparent. */
export async function socketWithoutSkin(page, url) {
  const raw = await rawSocket(page, url);
  await after(page, () => say(raw, 'surface skin visible=no'),
              now => now.surfaces.some(({ name, visible }) => name === 'skin' && !visible));
  return raw;
}

/** Unfolds whatever can be, so that nothing hides. */
export function unfold(page) {
  return page.evaluate(() => {
    for (const details of document.querySelectorAll('details')) details.open = true;
  });
}

/**
 * Red, green, blue and opacity of all pixels of a canvas, at the second refresh of the screen.
 * @param {import('playwright-core').Locator} canvas
 */
export async function canvasPixels(canvas) {
  const text = await canvas.evaluate(async element => {
    await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
    const { data } = element.getContext('2d').getImageData(0, 0, element.width, element.height);
    let bytes = '';  // An array of numbers would take seconds on its way to the test.
    for (const byte of data) bytes += String.fromCharCode(byte);
    return btoa(bytes);
  });
  return Uint8Array.from(Buffer.from(text, 'base64'));
}

/** How different the picture's pixels are: colors, and the share of the commonest one. */
export function lookAtPicture(page) {
  return page.getByTestId('frame').evaluate(canvas => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const counts = new Map();
    for (const pixel of new Uint32Array(data.buffer)) {
      counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
    }
    const most = Math.max(...counts.values());
    return { width: canvas.width, height: canvas.height, colors: counts.size,
             commonest: most / (canvas.width * canvas.height) };
  });
}

/**
 * Drags with the mouse in steps, each of them an event.
 * @param {{x: number, y: number}} from CSS pixels of the page
 * @param {{x: number, y: number}} to
 */
export async function drag(page, from, to, { steps = 8, button = 'left' } = {}) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down({ button });
  await page.mouse.move(to.x, to.y, { steps });
  await page.mouse.up({ button });
}

/** Measures a distance on the axial slice, across its middle. */
export async function measureAcross(page) {
  await page.getByTestId('choice-measure').click();
  const box = await page.getByTestId('slice-axial').boundingBox();
  for (const share of [0.4, 0.6]) {
    await page.mouse.click(box.x + box.width * share, box.y + box.height / 2);
  }
}

/** Drops files on the picture as a person does; paths are of this computer. */
export async function drop(page, files) {
  const session = await page.context().newCDPSession(page);
  const box = await page.getByTestId('stage').boundingBox();
  const data = { items: [], files, dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop']) {
    await session.send('Input.dispatchDragEvent',
                      { type, x: box.x + box.width / 2, y: box.y + box.height / 2, data });
  }
}

/** The middle of an element, in CSS pixels of the page. */
export async function middleOf(locator) {
  await locator.scrollIntoViewIfNeeded();
  const box = await locator.boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

/** The errors that the page shows to the person just now: messages, and why nothing was opened. */
export function errorsShown(page) {
  return page.locator('[data-testid=toast-error] p, [data-testid=open-error]:not([hidden])')
    .allTextContents();
}

/** Does something, and returns the file that the page saves. */
export async function saved(page, act) {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return readFile(await download.path());
}

/**
 * A connection of its own, without the page's code: what a script or an attacker would send. It
 * takes every frame at once and keeps the headers.
 * @param page where it runs; the origin of its connection
 * @param {string} url as `pxpl5 serve` printed it
 * @returns a handle for `say` and for `evaluate(self => ...)`; see connectInPage
 */
export function rawSocket(page, url) {
  const address = new URL('socket', url);
  address.search = new URL(url).search;
  address.protocol = address.protocol.replace('http', 'ws');
  return page.evaluateHandle(connectInPage, address.href);
}

/** Does a command line over a raw socket; returns the reply, whether done or failed. */
export function say(socket, line) {
  return socket.evaluate((self, line) => self.do(line), line);
}

/** Asks over a raw socket; returns the answer's JSON and bytes, or throws its sentence. */
export function ask(socket, question) {
  return socket.evaluate((self, question) => self.ask(question), question);
}

/** Runs in the page, and so must not use anything of this file. */
function connectInPage(address) {
  const socket = new WebSocket(address);
  socket.binaryType = 'arraybuffer';
  const self = { socket, frames: [], states: [], hello: null, waiting: new Map(), nextId: 1 };
  self.do = line => new Promise(resolve => {
    const id = self.nextId++;
    self.waiting.set(id, resolve);
    socket.send(JSON.stringify({ id, do: line }));
  });
  self.ask = question => new Promise((resolve, reject) => {
    const id = self.nextId++;
    self.waiting.set(id, ({ ok, error, ...answer }) => ok ? resolve(answer) : reject(Error(error)));
    socket.send(JSON.stringify({ id, ...question }));
  });
  const takeText = message => {
    if ('re' in message) {
      self.waiting.get(message.re)?.(message);
      self.waiting.delete(message.re);
    }
    self.hello = message.hello ?? self.hello;
    if (message.state) self.states.push(message.state);
  };
  const takeFrame = view => {
    const flags = view.getUint8(19);
    self.frames.push({ number: view.getUint32(4, true), revision: view.getUint32(8, true),
                       samples: view.getUint8(18), rests: (flags & 1) !== 0,
                       last: (flags & 2) !== 0,
                       digest: view.getBigUint64(24, true).toString(16).padStart(16, '0') });
    socket.send(JSON.stringify({ shown: view.getUint32(4, true) }));
  };
  const takeAnswer = (view, data) => {
    const [id, length] = [view.getUint32(4, true), view.getUint32(8, true)];
    const json = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 16, length)));
    const bytes = new Uint8Array(data, Math.ceil((16 + length) / 8) * 8);
    self.waiting.get(id)?.({ ok: true, json, bytes: [...bytes] });
    self.waiting.delete(id);
  };
  socket.onmessage = ({ data }) => {
    if (typeof data === 'string') return takeText(JSON.parse(data));
    const view = new DataView(data);
    return view.getUint32(0, true) === 0x46523550 ? takeFrame(view) : takeAnswer(view, data);
  };
  self.closed = new Promise(resolve => {
    socket.onclose = ({ code, reason }) => resolve({ code, reason });
  });
  const opened = new Promise(resolve => { socket.onopen = () => resolve(true); });
  return Promise.race([opened, self.closed]).then(() => self);
}
