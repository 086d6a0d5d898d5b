// Looking around: the pointer or a phone turns the view on the screen, and nothing else.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { after, drag, middleOf, say, settled, socketWithoutSkin, state, unfold } from '../steps.js';

const NEAR_PX = 1.5;  // From a click to its mark.
let raw;

usePage(['phantom:pelvis', 'resample=96x96x72'], async () => {
  raw = await socketWithoutSkin(page, server.url);
  await after(page, () => say(raw, 'view 20 10'));
  await unfold(page);
  await page.keyboard.press('Shift');  // Takes the first hint away.
});

/** How far the screen shows the patient from another side: degrees to the right and up. */
function turned(page) {
  return page.evaluate(() => {
    const { warp, state } = globalThis.pxpl5, { view } = warp, { camera } = state;
    const right = view.azimuth_deg - camera.azimuth_deg;
    return { right: right - 360 * Math.round(right / 360),
             up: view.elevation_deg - camera.elevation_deg, warped: warp.warped };
  });
}

/** Waits until the turn rests at or beyond these degrees, in their directions. */
async function turnedTo(page, right, up) {
  await page.waitForFunction(([right, up]) => {
    const { warp, state } = globalThis.pxpl5, { view } = warp, { camera } = state;
    const turn = view.azimuth_deg - camera.azimuth_deg;
    return Math.sign(right) * (turn - 360 * Math.round(turn / 360)) >= Math.abs(right) &&
      Math.sign(up) * (view.elevation_deg - camera.elevation_deg) >= Math.abs(up);
  }, [right, up]);
  return turned(page);
}

/** Waits until the picture itself is on the screen; returns what is shown. */
async function returned(page) {
  await page.waitForFunction(() => !globalThis.pxpl5.warp.warped);
  const screen = await page.getByTestId('stage').screenshot();
  return { digest: await page.getByTestId('badge-digest').textContent(),
           screen: createHash('sha256').update(screen).digest('hex') };
}

const off = async page => page.mouse.move(3, 3);  // The pointer is in the title bar.

test('the pointer turns the view by a few degrees, sends nothing, and the view returns exactly',
     async () => {
  await off(page);
  await settled(page);
  const before = await returned(page), { revision } = await state(page);
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.move(x + 150, y - 100);
  assert.deepEqual(await turned(page), { right: 0, up: 0, warped: false }, 'off by default');
  await byId('parallax-switch').check();
  const sent = [];
  const session = await page.context().newCDPSession(page);
  await session.send('Network.enable');
  session.on('Network.webSocketFrameSent', ({ response }) => sent.push(response.payloadData));
  await page.mouse.move(x + 150, y - 100);
  const right = await turnedTo(page, 2, 1);
  assert.ok(right.right < 8.5 && right.up < 5.5 && right.warped, JSON.stringify(right));
  await shoot(page, 'parallax-right');
  assert.equal(await byId('badge-quality').textContent(), 'warped');
  assert.equal(await byId('badge-digest').textContent(), '');
  await page.mouse.move(x - 150, y + 100);
  await turnedTo(page, -2, -1);
  await shoot(page, 'parallax-left');
  await off(page);
  assert.deepEqual(await returned(page), before);
  assert.equal((await state(page)).revision, revision);
  assert.deepEqual(sent.filter(each => !/"(shown|ping)"/.test(each)), []);
  await session.detach();
});

test('a click means what is on the screen', async () => {
  const { x, y } = await middleOf(byId('stage'));
  await page.evaluate(() => {
    globalThis.clicked = { view: null, points: [] };
    addEventListener('pointerup', () => { globalThis.clicked.view = globalThis.pxpl5.warp.view; },
                     { capture: true });
    document.addEventListener('place', ({ detail }) =>
      globalThis.clicked.points.push(detail.p_mm));
  });
  let count = 0;
  for (const [right, up] of [[150, -70], [-150, -120], [-160, 100], [150, 110], [0, -60]]) {
    await page.mouse.move(x + right, y + up);
    await page.waitForFunction(() => globalThis.pxpl5.warp.warped);
    await turnedTo(page, right / 100, -up / 100);
    await page.mouse.click(x + right, y + up);
    const shown = await page.waitForFunction(count =>
      globalThis.clicked.points.length > count && globalThis.clicked.points[count], count);
    const { place, degrees } = await page.evaluate(async p_mm => {
      const load = name => import(new URL(name, location.href).href);
      const { cameraAt } = await load('picture/camera.js');
      const { projectToPicture } = await load('picture/projection.js');
      const { camera, size } = globalThis.pxpl5.state, { view } = globalThis.clicked;
      const clip = cameraAt(view, camera, size[0] / size[1]).patient_to_clip;
      const box = document.querySelector('#frame').getBoundingClientRect();
      const at = projectToPicture(clip, p_mm, box.width, box.height);
      return { place: { x: box.left + at.x, y: box.top + at.y },
               degrees: Math.abs(view.azimuth_deg - camera.azimuth_deg) };
    }, await shown.jsonValue());
    ++count;
    assert.ok(degrees > 0.5 || right === 0, `turned by ${degrees}`);
    const off = Math.hypot(place.x - x - right, place.y - y - up);
    assert.ok(off < NEAR_PX, `${JSON.stringify([x + right, y + up, place])}: ${off} pixels`);
    await returned(page);
  }
});

test('a drag turns the view itself, and the view of the drag rests', async () => {
  const at = await middleOf(byId('stage'));
  await page.mouse.move(at.x + 150, at.y);
  await turnedTo(page, 1, 0);
  const before = (await state(page)).camera.azimuth_deg;
  await after(page, () => drag(page, { x: at.x + 150, y: at.y }, { x: at.x, y: at.y }));
  await off(page);
  await returned(page);
  await settled(page);
  assert.ok(Math.abs((await state(page)).camera.azimuth_deg - before) > 10);
  assert.deepEqual(await turned(page), { right: 0, up: 0, warped: false });
  await after(page, () => say(raw, 'view 20 10 roll=0 fit=yes'));
});

test('switched off, the view returns', async () => {
  const at = await middleOf(byId('stage'));
  await page.mouse.move(at.x + 150, at.y);
  await turnedTo(page, 1, 0);
  await byId('parallax-switch').evaluate(box => box.click());
  await returned(page);
  await page.mouse.move(at.x + 140, at.y);
  assert.deepEqual(await turned(page), { right: 0, up: 0, warped: false });
  await byId('warp-switch').uncheck();
  assert.ok(await byId('parallax-switch').isDisabled());
  await byId('warp-switch').check();
});

test('the orientation of a phone turns the view; a touch makes it the middle', async () => {
  const phone = await openPage(browser, server.url, { viewport: { width: 412, height: 700 },
                                                      hasTouch: true, isMobile: true });
  await unfold(phone.page);
  await settled(phone.page);
  // Chromium's headless shell has no sensors, not even simulated ones.
  const orient = (alpha, beta, gamma) => phone.page.evaluate(angles => {
    dispatchEvent(new DeviceOrientationEvent('deviceorientation', angles));
  }, { alpha, beta, gamma });
  await phone.page.keyboard.press('Shift');
  const before = await returned(phone.page);
  await orient(0, 50, 0);
  await phone.page.getByTestId('parallax-switch').check();
  await orient(0, 60, 0);  // The first event after the switch is the middle.
  await orient(0, 57, -4);
  const { right, up } = await turnedTo(phone.page, 2, -2);
  assert.ok(right < 6 && up > -5, `${right} ${up}`);
  await orient(0, 60, 4);
  await turnedTo(phone.page, -2, 0);
  await shoot(phone.page, 'parallax-phone');
  await orient(0, 60, 0);
  assert.equal((await returned(phone.page)).digest, before.digest);
  await orient(40, 10, 0);
  const most = await turnedTo(phone.page, -6, -4);
  assert.ok(Math.abs(most.right) < 8.5 && Math.abs(most.up) < 5.5, 'a few degrees at most');
  await phone.page.getByTestId('stage').tap({ position: { x: 100, y: 200 } });
  await orient(40, 12, 1);
  assert.equal((await returned(phone.page)).digest, before.digest);
  await phone.close();
});

test('where the orientation cannot be had, the page says why', async () => {
  const cases = [
    [/certificate: --tls-cert and --tls-key/,
     () => Object.defineProperty(globalThis, 'isSecureContext', { value: false })],
    [/did not let this page read the orientation/,
     () => { DeviceOrientationEvent.requestPermission = async () => 'denied'; }],
  ];
  for (const [sentence, script] of cases) {
    const phone = await openPage(browser, server.url,
      { script, viewport: { width: 412, height: 700 }, hasTouch: true, isMobile: true });
    await unfold(phone.page);
    await phone.page.getByTestId('parallax-switch').check();
    await phone.page.getByText(sentence).waitFor();
    await phone.close();
  }
});
