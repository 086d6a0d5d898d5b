// The pictures of a headset: exact at the pose that they are drawn for, nearly so beside it, right
// in what is new, and refused with a sentence where the page's address is not secure.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, launchBrowser, page, serve, server, shoot, usePage } from '../harness.js';
import { after, say, socketWithoutSkin } from '../steps.js';
import { loadModules } from '../warp/warping.js';
import { figures, figuresWhen, openWithHeadset, setHead, settledPair, wear }
  from './emulated.js';
import { comparePairs, keepPairs, loadPairs, warpedPair } from './pairs.js';

const LEAST_PSNR_DB = 28;      // 3 cm aside, in means of 4 x 4 pixels.
const LEAST_GAIN_DB = 15;      // Over a picture that is only turned.
const MOST_UNKNOWN = 0.08;     // Share of the surface's pixels that only the exact picture shows.

let raw;

usePage(['phantom:pelvis', 'resample=128x128x96'], async () => {
  raw = await socketWithoutSkin(page, server.url);
});

/** A worn headset whose pairs are kept. */
async function wearKeeping() {
  const own = await openWithHeadset(browser, server.url, { scripts: [keepPairs] });
  await wear(own.page);
  await own.page.evaluate(loadModules);
  await own.page.evaluate(loadPairs);
  return own;
}

/** The number of the newest pair at a pose of the head. */
async function pairAt(page, ...head) {
  const before = await page.evaluate(() => globalThis.pxpl5.headset.pose);
  await setHead(page, ...head);
  await page.waitForFunction(before => globalThis.pxpl5.headset.pose > before, before);
  return settledPair(page);
}

/** Pairs of one size at two poses of the head: a busy machine draws some smaller. */
async function pairsAt(page, first, second) {
  for (let tries = 0; tries < 20; tries++) {
    const poses = [await pairAt(page, ...first), await pairAt(page, ...second)];
    const sizes = await page.evaluate(poses => poses.map(pose =>
      new DataView(globalThis.pairs.get(pose).message).getUint32(12, true)), poses);
    if (sizes[0] === sizes[1]) return poses;
  }
  throw new Error('no two pairs of one size in 20 tries');
}

test('at the pose that it was drawn for, each eye is the picture, pixel by pixel', async () => {
  const own = await wearKeeping();
  for (const head of [[0.1, 1.5, 0.1], [-0.2, 1.3, -0.1, 20, -5]]) {
    const found = await own.page.evaluate(warpedPair, await pairAt(own.page, ...head));
    assert.equal(found.length, 2);
    for (const { differing, covered, beside } of found) {
      assert.ok(covered > 5000, `${covered}`);
      assert.equal(differing, 0, `${differing} of ${covered} pixels of the surface differ`);
      assert.equal(beside, 0, `${beside} pixels beside the surface differ`);
    }
  }
  await own.close();
});

test('3 cm aside, the warped eyes are nearly the exact ones', async t => {
  const own = await wearKeeping();
  for (const [name, move] of Object.entries({ right: [0.03, 0, 0], up: [0, 0.03, 0],
                                              nearer: [0, 0, -0.03] })) {
    const head = [0, 1.45, 0.05];
    const pair = await pairsAt(own.page, head, head.map((each, k) => each + move[k]));
    for (const found of await own.page.evaluate(comparePairs, pair)) {
      const { warped_db: warped, turned_db: turned, unknown, covered } = found;
      t.diagnostic(`${name}: ${warped.toFixed(1)} dB, only turned ${turned.toFixed(1)} dB, ` +
        `unknown ${(100 * unknown).toFixed(2)} % of ${covered} pixels`);
      assert.ok(warped >= LEAST_PSNR_DB, `${name}: ${warped} dB`);
      // Nearer, the window follows: what is only turned fits better than beside.
      if (name !== 'nearer') {
        assert.ok(warped >= turned + LEAST_GAIN_DB, `${name}: ${warped} dB, turned ${turned} dB`);
      }
      assert.ok(unknown < MOST_UNKNOWN, `${name}: ${unknown} are unknown`);
    }
  }
  await own.close();
});

test('a change of the scene leads to a new pair of the same pose', async () => {
  const own = await wearKeeping();
  const pose = await pairAt(own.page, 0.05, 1.5, 0.1);
  const of = pose => own.page.evaluate(pose =>
    new DataView(globalThis.pairs.get(pose).message).getUint32(8, true), pose);
  const before = await of(pose);
  const { pairs } = await figures(own.page);
  const { revision } = await after(page, () => say(raw, 'surface bone color=#ff8800'));
  assert.ok(revision > before);
  await own.page.waitForFunction(([pose, revision]) =>
    new DataView(globalThis.pairs.get(pose).message).getUint32(8, true) >= revision,
    [pose, revision]);
  await figuresWhen(own.page, (now, pairs) => now.pairs > pairs, pairs);
  await shoot(own.page, 'headset-orange');
  await after(page, () => say(raw, 'undo'));
  await own.close();
});

test('an address that is not secure: no button, and what to do', async () => {
  const own = await serve('phantom:pelvis', 'resample=48x48x24', '--allow-host', 'headset.test');
  const plain = await launchBrowser('MAP headset.test 127.0.0.1');
  try {
    const url = own.url.replace('127.0.0.1', 'headset.test');
    const opened = await openWithHeadset(plain, url);
    assert.equal(await opened.page.evaluate(() => isSecureContext), false);
    assert.ok(await opened.page.getByTestId('headset').isHidden());
    await opened.page.getByTestId('help').click();
    const said = await opened.page.getByTestId('headset-reason').textContent();
    const { port } = new URL(url);
    assert.match(said, /not secure/);
    assert.match(said, /--tls-cert/);
    assert.ok(said.includes(`adb reverse tcp:${port} tcp:${port}`), said);
    await shoot(opened.page, 'headset-insecure');
    // The browser ignores a header that has a meaning on secure addresses only.
    assert.ok(opened.complaints.every(each => /Opener-Policy.*untrustworthy/.test(each)),
              `${opened.complaints}`);
    opened.complaints.length = 0;
    await opened.close();
  } finally {
    await plain.close();
    await own.stop();
  }
});
