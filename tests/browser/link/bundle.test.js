// The files that a browser loads for the page: few, compressed, and kept until they change.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, openPage, server, useServer } from '../harness.js';
import { settled } from '../steps.js';

const MOST_REQUESTS = 20, MOST_BYTES = 180_000;

useServer();

/** Notes each HTTP request of a page: address, bytes with their head, whether from the cache. */
async function noteRequests(context, page) {
  const session = await context.newCDPSession(page);
  const requests = new Map();
  await session.send('Network.enable');
  session.on('Network.responseReceived', ({ requestId, response, type }) =>
    requests.set(requestId, { url: new URL(response.url), type, cached: response.fromDiskCache,
                              caching: response.headers['cache-control'], bytes: 0 }));
  session.on('Network.requestServedFromCache', ({ requestId }) => requests.set(requestId,
    { ...requests.get(requestId), cached: true }));
  session.on('Network.loadingFinished', ({ requestId, encodedDataLength }) => {
    const request = requests.get(requestId);
    if (request) request.bytes = encodedDataLength;
  });
  return () => [...requests.values()];
}

test('the page is a few small files, which a second visit takes from the cache', async t => {
  const context = await browser.newContext();
  const page = await context.newPage();
  const requests = await noteRequests(context, page);
  await page.goto(server.url);
  await settled(page);
  const first = requests();
  const bytes = first.reduce((sum, each) => sum + each.bytes, 0);
  t.diagnostic(`${first.length} requests, ${bytes} bytes`);
  const names = first.map(each => each.url.pathname);
  assert.ok(names.includes('/main.js') && names.includes('/page.css'), names.join(' '));
  assert.ok(first.length < MOST_REQUESTS, names.join(' '));
  assert.ok(bytes > 10_000 && bytes < MOST_BYTES, `${bytes} bytes`);

  const again = await context.newPage();
  const later = await noteRequests(context, again);
  await again.goto(server.url);
  await settled(again);
  const kept = later().filter(each => each.cached).map(each => each.url.pathname).sort();
  assert.deepEqual(kept.filter(name => /main|page/.test(name)), ['/main.js', '/page.css']);
  await context.close();
});

test('the texts of a language are loaded by its readers alone, and kept until they change',
  async () => {
    const english = await browser.newContext({ locale: 'en-US' });
    const plain = await english.newPage();
    const without = await noteRequests(english, plain);
    await plain.goto(server.url);
    await settled(plain);
    assert.deepEqual(without().filter(each => each.url.pathname.endsWith('de.js')), []);
    await english.close();

    const context = await browser.newContext({ locale: 'de-DE' });
    const visit = async () => {
      const page = await context.newPage();
      const requests = await noteRequests(context, page);
      await page.goto(server.url);
      await settled(page);
      assert.equal(await page.locator('html').getAttribute('lang'), 'de');
      return requests().filter(each => each.url.pathname === '/de.js');
    };
    const [first, ...others] = await visit();
    assert.deepEqual(others, []);
    assert.match(first.url.search, /^\?v=\w{8}$/);
    assert.match(first.caching, /immutable/);
    assert.equal(first.cached, false);
    assert.deepEqual((await visit()).map(({ cached }) => cached), [true]);
    await context.close();
  });

test('the source map leads from the bundle to the modules', async () => {
  const opened = await openPage(browser, server.url);
  const { sources, text } = await opened.page.evaluate(async () => {
    const map = await (await fetch('main.js.map')).json();
    const k = map.sources.findIndex(each => each.endsWith('surfaces/axis.js'));
    return { sources: map.sources, text: map.sourcesContent[k] };
  });
  assert.ok(sources.length > 60, `${sources.length} modules`);
  assert.match(text, /export class Scale/);
  await opened.close();
});

test('modules are sent unchanged and are not cached', async () => {
  const opened = await openPage(browser, server.url);
  const [plain, bundled, other] = await opened.page.evaluate(async () => {
    const get = async name => {
      const response = await fetch(name);
      return { text: await response.text(), caching: response.headers.get('cache-control') };
    };
    const src = document.querySelector('script').getAttribute('src');
    return [await get('surfaces/axis.js'), await get(src), await get('main.js')];
  });
  assert.match(plain.text, /^\/\/ A linear axis/);
  assert.equal(plain.caching, 'no-store');
  assert.match(bundled.caching, /immutable/);
  assert.equal(other.caching, 'no-store', 'without the hash');
  assert.equal(other.text, bundled.text);
  await opened.close();
});
