// The connection between page and server: who may connect, what is refused, what survives a loss,
// and that a flood of input ends with the newest state on the screen.
import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import test from 'node:test';
import { browser, openPage, serve, server, useServer } from './harness.js';
import { after, rawSocket, say, settled, state, stateWhen } from './steps.js';

const LONGEST_MESSAGE = 64 * 1024;  // host/serve/README.md
const FLOOD = 1000;
const FLOOD_A_FRAME = 5;  // 60 times a second: below the 400 messages a second that are allowed.

useServer();

/**
 * Keeps the page's own sockets, newest last, so that a test can do to them what a network does;
 * while `isRefused`, none can be opened.
 */
function keepSockets() {
  const Plain = globalThis.WebSocket;
  globalThis.sockets = [];
  globalThis.WebSocket = class extends Plain {
    constructor(url) {
      super(globalThis.isRefused ? new URL('no-socket', url) : url);
      globalThis.sockets.push(this);
    }
  };
}

test('a wrong token is refused in plain words, and shows nothing of the page', async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  const wrong = new URL(server.url);
  wrong.searchParams.set('token', '0'.repeat(32));
  const bare = ['/', '/main.js', '/socket'].map(path => new URL(path, server.url).href);
  for (const url of [wrong.href, ...bare]) {
    const response = await page.goto(url);
    assert.equal(response.status(), 403, url);
    assert.match(await page.locator('body').innerText(), /token .*pxpl5 serve|pxpl5 serve .*token/);
  }
  await context.close();
});

test('a page of another origin cannot connect, even with the token', async () => {
  const other = createServer((_, response) => {
    response.setHeader('content-type', 'text/html');
    response.end('<title>another origin</title>');
  });
  await new Promise(listening => other.listen(0, '127.0.0.1', listening));
  const page = await (await browser.newContext()).newPage();
  await page.goto(`http://127.0.0.1:${other.address().port}/`);
  const theirs = await rawSocket(page, server.url);
  assert.equal((await theirs.evaluate(self => self.closed)).code, 1006, 'the handshake failed');
  assert.equal(await theirs.evaluate(self => self.hello), null);
  await page.context().close();
  other.close();

  const own = await openPage(browser, server.url);
  const ours = await rawSocket(own.page, server.url);
  await own.page.waitForFunction(self => self.hello?.role === 'driver', ours);
  await own.close();
});

test('a message that is too long closes its connection with 1009, and no other', async () => {
  const { page, close } = await openPage(browser, server.url);
  const [fits, long] = [await rawSocket(page, server.url), await rawSocket(page, server.url)];
  const blanks = length => `info${' '.repeat(length)}`;
  const reply = await say(fits, blanks(LONGEST_MESSAGE - 200));
  assert.equal(reply.ok, true, reply.error);
  await long.evaluate((self, line) => void self.do(line), blanks(LONGEST_MESSAGE));
  assert.equal((await long.evaluate(self => self.closed)).code, 1009);
  assert.equal((await say(fits, 'info')).ok, true);
  await close();
});

test('what is no message of the protocol is answered, and the connection lives', async () => {
  const { page, close } = await openPage(browser, server.url);
  const raw = await rawSocket(page, server.url);
  const before = (await state(page)).revision;
  for (const text of ['', 'no json', '[]', '7', '{}', '{"do":3}', '{"id":"x","do":"info"}',
                      '{"id":9}', '{"shown":-1}', '{"shown":4294967295}', '{"ask":"x"}',
                      '"'.repeat(2000)]) {
    await raw.evaluate((self, text) => self.socket.send(text), text);
  }
  for (const line of ['', 'bogus', 'view', 'surface', 'quit', 'view nan nan', 'size 0x0']) {
    const reply = await say(raw, line);
    if (!reply.ok) assert.match(reply.error, /\w+ \w+/, `a sentence for '${line}'`);
  }
  const { ok, error } = await say(raw, 'bogus');
  assert.equal(ok, false);
  assert.match(error, /bogus/);
  assert.equal((await say(raw, 'info')).ok, true);
  assert.equal((await state(page)).revision, before, 'nothing of this changed the scene');
  await close();
});

test('after a lost connection the page connects again and shows the state as it is', async () => {
  const context = await browser.newContext();
  await context.addInitScript(keepSockets);
  const page = await context.newPage();
  await page.goto(server.url);
  const first = await settled(page);
  for (const drop of ['too long', 'closed', 'refused for a while']) {
    await page.evaluate(({ drop, bytes }) => {
      globalThis.framesBefore = globalThis.pxpl5.frames;
      globalThis.isRefused = drop === 'refused for a while';
      const socket = globalThis.sockets.at(-1);
      drop === 'too long' ? socket.send(' '.repeat(bytes)) : socket.close();
    }, { drop, bytes: LONGEST_MESSAGE + 1 });
    if (drop === 'refused for a while') {
      await page.getByTestId('lost').waitFor({ state: 'visible' });
      await page.evaluate(() => { globalThis.isRefused = false; });
    }
    await page.waitForFunction(() => globalThis.pxpl5.frames > globalThis.framesBefore);
    await page.getByTestId('lost').waitFor({ state: 'hidden' });
    assert.equal((await settled(page)).digest, first.digest);
  }
  const turned = await after(page, async () => {
    await page.getByTestId('stage').focus();
    await page.keyboard.press('ArrowRight');
  });
  assert.notEqual(turned.digest, first.digest, 'the page works as before');
  await context.close();
});

test('a server that stops answering is shown while it is asked, and no longer', async () => {
  const { page, close } = await openPage(browser, server.url);
  await settled(page);
  const stalled = page.getByTestId('stalled');
  assert.ok(await stalled.isHidden());
  server.child.kill('SIGSTOP');
  try {
    await page.getByTestId('stage').focus();
    await page.keyboard.press('ArrowRight');
    await stalled.getByText(/No answer .* \d+ s/).waitFor();
  } finally {
    server.child.kill('SIGCONT');
  }
  await stalled.waitFor({ state: 'hidden' });
  await settled(page);
  await close();
});

test('a server that stops is shown while nothing is asked, to a watcher, too', async () => {
  const driver = await openPage(browser, server.url);
  const watcher = await openPage(browser, server.watchUrl);
  await settled(driver.page);
  const stalled = [driver, watcher].map(({ page }) => page.getByTestId('stalled'));
  server.child.kill('SIGSTOP');
  try {
    for (const each of stalled) await each.getByText(/No answer .* \d+ s/).waitFor();
  } finally {
    server.child.kill('SIGCONT');
  }
  for (const each of stalled) await each.waitFor({ state: 'hidden' });
  await driver.close();
  await watcher.close();
});

test('a server that was started again with another token is told of', async () => {
  const first = await serve('phantom:sphere', 'resample=16x16x16');
  const context = await browser.newContext();
  const page = await context.newPage();
  let second;
  try {
    await page.goto(first.url);
    await settled(page);
    await first.stop();
    await page.getByTestId('lost').waitFor({ state: 'visible' });
    await page.getByTestId('lost-next').getByText('Reconnecting').waitFor();
    second = await serve('phantom:sphere', 'resample=16x16x16', '--port', new URL(first.url).port);
    await page.getByTestId('lost-next').getByText('new address').waitFor();
  } finally {
    await context.close();
    await second?.stop();
  }
});

test('the address bar keeps no token, and the page can be loaded again', async () => {
  const { page, close } = await openPage(browser, server.url);
  assert.doesNotMatch(page.url(), /token/);
  assert.doesNotMatch(await page.evaluate(() => location.href), /token/);
  await page.reload();
  await settled(page);
  await after(page, async () => {
    await page.getByTestId('stage').focus();
    await page.keyboard.press('ArrowRight');
  });
  await close();
});

test('a tab without the token has the page, but not the session, and says why', async () => {
  const context = await browser.newContext();
  try {
    const page = await context.newPage();
    await page.goto(server.url);
    await settled(page);
    const bare = await context.newPage();
    await bare.goto(page.url());
    await bare.getByTestId('lost-next').getByText('without the token').waitFor();
    assert.equal(await bare.evaluate(() => globalThis.pxpl5?.frames ?? 0), 0);
  } finally {
    await context.close();
  }
});

test('a watcher sees what the driver does, and can do nothing', async () => {
  const driver = await openPage(browser, server.url);
  const watcher = await openPage(browser, server.watchUrl);
  const raw = await rawSocket(driver.page, server.url);
  const { revision } = await say(raw, 'view 75 20');
  await stateWhen(watcher.page, (now, wanted) => now.revision >= wanted, revision);
  const seen = await settled(watcher.page);
  assert.deepEqual({ ...seen, frames: 0 }, { ...await settled(driver.page), frames: 0 });

  await watcher.page.getByTestId('stage').focus();
  await watcher.page.keyboard.press('ArrowRight');
  await watcher.page.keyboard.press('r');
  const theirs = await rawSocket(watcher.page, server.watchUrl);
  const reply = await say(theirs, 'view 10 0');
  assert.equal(reply.ok, false);
  assert.match(reply.error, /watch/);
  const now = await state(watcher.page);
  assert.equal(now.revision, revision, 'neither page nor socket of a watcher changed anything');
  assert.equal(now.camera.azimuth_deg, 75);
  await watcher.close();
  await driver.close();
});

/** In the page: sends many settings as fast as frames of the screen come, then one last. */
function flood(self, { count, each, last }) {
  return new Promise(resolve => {
    let sent = 0;
    const step = () => {
      for (let i = 0; i < each && sent < count; i++, sent++) {
        self.do(sent % 2 ? `surface bone iso=${150 + sent % 200 + 0.5}` : `view ${sent % 360} 10`);
      }
      sent < count ? requestAnimationFrame(step) : self.do(last[0]).then(() =>
        self.do(last[1])).then(resolve);
    };
    step();
  });
}

test('after a flood of input the newest state is shown, and never an older one after a newer',
     async () => {
  const { page, close } = await openPage(browser, server.url);
  const raw = await rawSocket(page, server.url);
  const reply = await raw.evaluate(flood, { count: FLOOD, each: FLOOD_A_FRAME,
                                       last: ['surface bone iso=210.5', 'view 33 -12'] });
  assert.equal(reply.ok, true, reply.error);
  const shown = await settled(page);
  assert.equal(shown.revision, reply.revision);
  const { camera, surfaces } = await state(page);
  assert.deepEqual([camera.azimuth_deg, camera.elevation_deg], [33, -12]);
  assert.equal(surfaces.find(({ name }) => name === 'bone').isovalue, 210.5);

  await page.waitForFunction(({ self, revision }) => {
    const frame = self.frames.at(-1);
    return frame?.revision === revision && frame.last;
  }, { self: raw, revision: reply.revision });
  const frames = await raw.evaluate(self => self.frames);
  for (const [index, frame] of frames.slice(1).entries()) {
    assert.ok(frame.number > frames[index].number, 'frames are numbered in their order');
    assert.ok(frame.revision >= frames[index].revision, `frame ${frame.number} is stale`);
  }
  assert.equal(frames.at(-1).digest, shown.digest);

  // Another view and back: the same state is drawn again.
  await after(page, () => say(raw, 'view 90 0'));
  assert.equal((await after(page, () => say(raw, 'view 33 -12'))).digest, shown.digest);
  await close();
});

test('the end of a job is shown with the command that opens the saved session', async () => {
  const ending = await serve('phantom:sphere');
  const { page, close } = await openPage(browser, ending.url);
  try {
    await settled(page);
    const banner = page.getByTestId('ending');
    assert.ok(await banner.isHidden());
    ending.child.kill('SIGUSR1');
    await banner.getByText(/This command opens it again: pxpl5 serve --session \S/).waitFor();
    assert.match(await banner.textContent(), /^This session ends soon: .* SIGUSR1\. /);
  } finally {
    await close();
    assert.equal((await ending.stop()).code, 0);
  }
});
