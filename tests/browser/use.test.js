// Use of the picture and the surfaces by mouse, keyboard and touch.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, usePage } from './harness.js';
import { after, drag, lookAtPicture, middleOf, settled, state, stateWhen, unfold }
  from './steps.js';

usePage();

const surfaceOf = (now, name) => now.surfaces.find(each => each.name === name);

/** Presses keys with the picture in focus. */
async function press(...keys) {
  await byId('stage').focus();
  for (const key of keys) await page.keyboard.press(key);
}

test('a first visit shows a picture, a title and the histogram', async () => {
  const shown = await settled(page);
  assert.match(shown.digest, /^[0-9a-f]{16}$/);
  const picture = await lookAtPicture(page);
  assert.ok(picture.colors > 200 && picture.commonest < 0.9, JSON.stringify(picture));
  assert.match(await page.title(), /pelvis.*pxpl5|pxpl5.*pelvis/i);
  const { surfaces, size } = await state(page);
  assert.deepEqual([picture.width, picture.height], size);
  assert.ok(surfaces.length >= 1);
  for (const { name } of surfaces) await byId(`handle-${name}`).waitFor();
  const area = await byId('histogram').locator('path.area').getAttribute('d');
  assert.ok(area.length > 1000, 'the histogram has an outline');
});

test('dragging a handle of the histogram moves the surface', async () => {
  const old = await settled(page);
  const was = surfaceOf(await state(page), 'bone');
  const grip = await middleOf(byId('handle-bone').locator('.reach'));
  const moved = await after(page, () => drag(page, grip, { x: grip.x + 40, y: grip.y }));
  const bone = surfaceOf(moved.state, 'bone');
  assert.ok(bone.isovalue > was.isovalue + 50, `${was.isovalue} to ${bone.isovalue}`);
  assert.ok(bone.triangles < was.triangles && bone.triangles > 0);
  assert.notEqual(moved.digest, old.digest);
  assert.equal(moved.revision, moved.state.revision);
  assert.equal(Number(await byId('iso-bone').inputValue()), bone.isovalue);
  assert.equal(Number(await byId('handle-bone').getAttribute('aria-valuenow')), bone.isovalue);

  const typed = await after(page, async () => {
    await byId('iso-bone').fill(String(was.isovalue));
    await byId('iso-bone').press('Enter');
  });
  assert.equal(typed.digest, old.digest, 'the old isovalue shows the old picture');
  await byId('handle-bone').focus();
  const stepped = await after(page, () => page.keyboard.press('ArrowLeft'));
  assert.ok(surfaceOf(stepped.state, 'bone').isovalue < was.isovalue);
});

test('mouse: a drag turns, the right button moves, the wheel zooms, two clicks reset', async () => {
  const old = { ...await settled(page), state: await state(page) };
  const at = await middleOf(byId('stage'));
  const turned = await after(page, () => drag(page, at, { x: at.x + 90, y: at.y + 20 }));
  assert.notEqual(turned.state.camera.azimuth_deg, old.state.camera.azimuth_deg);
  assert.notEqual(turned.digest, old.digest);

  const panned = await after(page, () =>
    drag(page, at, { x: at.x + 50, y: at.y - 30 }, { button: 'right' }));
  const [right, up] = panned.state.camera.pan_mm.map((mm, i) => mm - turned.state.camera.pan_mm[i]);
  assert.ok(right > 0 && up > 0, `moved by ${right}, ${up} mm`);
  assert.ok(Math.abs(right / up - 5 / 3) < 0.05, 'as far as the pointer, both ways');
  assert.equal(panned.state.camera.azimuth_deg, turned.state.camera.azimuth_deg);

  const zoomed = await after(page, () => page.mouse.wheel(0, -200));
  assert.ok(zoomed.state.camera.zoom > panned.state.camera.zoom * 1.1);
  const reset = await after(page, () => page.mouse.dblclick(at.x, at.y));
  assert.deepEqual(reset.state.camera, old.state.camera, 'as the volume was shown first');
  assert.equal(reset.state.camera.roll_deg, 0);
});

test('keyboard: arrows turn, plus zooms, digits choose a view, R resets', async () => {
  const start = await after(page, () => press('4'));
  const turned = await after(page, () => press('ArrowRight'));
  assert.notEqual(turned.state.camera.azimuth_deg, start.state.camera.azimuth_deg);
  const zoomed = await after(page, () => press('+'));
  assert.ok(zoomed.state.camera.zoom > turned.state.camera.zoom);
  const named = await after(page, () => press('1'));
  assert.deepEqual([named.state.camera.azimuth_deg, named.state.camera.elevation_deg], [0, 0]);
  await after(page, () => press('3'));
  // In one refresh of the screen: the turn, which waits for the next, must not come after it.
  const reset = await after(page, () => byId('stage').evaluate(stage => {
    for (const key of ['ArrowLeft', '+', 'r']) {
      stage.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    }
  }));
  assert.deepEqual(reset.state.camera, named.state.camera);
});

test('touch: one finger turns, two move and zoom', async () => {
  const touch = await openPage(browser, server.url, { hasTouch: true });
  const session = await touch.context.newCDPSession(touch.page);
  const at = await middleOf(touch.page.getByTestId('stage'));
  const send = (type, ...points) => session.send('Input.dispatchTouchEvent', { type,
    touchPoints: points.map(([x, y], id) => ({ x: at.x + x, y: at.y + y, id })) });
  const start = await after(touch.page, async () => {
    await touch.page.getByTestId('stage').focus();
    await touch.page.keyboard.press('2');
  });
  const turned = await after(touch.page, async () => {
    await send('touchStart', [0, 0]);
    for (const x of [20, 40, 60]) await send('touchMove', [x, 5]);
    await send('touchEnd');
  });
  assert.notEqual(turned.state.camera.azimuth_deg, start.state.camera.azimuth_deg);
  const pinched = await after(touch.page, async () => {
    await send('touchStart', [-40, 0]);
    await send('touchStart', [-40, 0], [40, 0]);
    for (const x of [60, 80, 100]) await send('touchMove', [-x, 0], [x, 0]);
    await send('touchEnd');
  });
  const factor = pinched.state.camera.zoom / turned.state.camera.zoom;
  assert.ok(Math.abs(factor - 2.5) < 0.3, `fingers 2.5 times apart zoom ${factor} times`);
  await touch.close();
  await after(page, () => press('r'));
});

test('a click on tissue makes its value the isovalue', async () => {
  await byId('choose-bone').click();
  const was = surfaceOf(await state(page), 'bone').isovalue;
  await byId('tissue-mode').click();
  const at = await middleOf(byId('stage'));
  const set = await after(page, () => page.mouse.click(at.x, at.y - 60));
  const { isovalue } = surfaceOf(set.state, 'bone');
  assert.notEqual(isovalue, was);
  assert.ok(Number.isFinite(isovalue));
  await page.keyboard.press('Escape');
  const back = await after(page, async () => {
    await byId('iso-bone').fill(String(was));
    await byId('iso-bone').press('Enter');
  });
  assert.equal(surfaceOf(back.state, 'bone').isovalue, was);
});

test('the same mode takes the value from a slice, and ends with its surface', async () => {
  await byId('choose-bone').click();
  const was = surfaceOf(await state(page), 'bone').isovalue;
  await byId('tab-slices').click();
  assert.equal(await byId('slices-surface').inputValue(), 'bone');
  await byId('tissue-mode').click();
  const box = await byId('slice-axial').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + 0.4 * box.height);
  const value = Number((await byId('slices-readout').locator('b').innerText()).split(' ')[0]);
  const set = await after(page, () => page.mouse.click(box.x + box.width / 2,
    box.y + 0.4 * box.height));
  const { isovalue } = surfaceOf(set.state, 'bone');
  assert.notEqual(isovalue, was);
  assert.ok(Math.abs(isovalue - value) <= 0.5, `${isovalue}, the slice has ${value} there`);
  await byId('choose-skin').click();
  assert.equal(await byId('tissue-mode').getAttribute('aria-pressed'), 'false');
  assert.equal(await byId('slices-surface').inputValue(), 'skin');
  await byId('choose-bone').click();
  await after(page, () => page.keyboard.press('u'));
  assert.equal(surfaceOf(await state(page), 'bone').isovalue, was);
});

test('surfaces: add a tissue, color, opacity, hide, parts, certificate, remove', async () => {
  const count = (await state(page)).surfaces.length;
  const added = await after(page, () => byId('preset-muscle').click());
  assert.equal(added.state.surfaces.length, count + 1);
  const muscle = (act, holds) => after(page, act, new Function('now', `const muscle =
    now.surfaces.find(({ name }) => name === 'muscle'); return ${holds};`));
  const colored = await muscle(() => byId('surface-color-muscle').fill('#3060f0'),
                               "muscle.color === '#3060f0'");
  const seen = await muscle(() => byId('surface-opacity-muscle').fill('0.5'),
                            'muscle.opacity === 0.5');
  const rimmed = await muscle(() => byId('surface-rim-muscle').fill('0.75'),
                              'muscle.rim === 0.75');
  const hidden = await muscle(() => byId('surface-visible-muscle').uncheck(), '!muscle.visible');
  const digests = [added, colored, seen, rimmed, hidden].map(({ digest }) => digest);
  assert.equal(new Set(digests).size, digests.length, 'each change shows');

  await byId('choose-bone').click();
  const parts = byId('surface-components-bone');
  const areDrawn = (now, words) => words.includes(
    now.surfaces.find(({ name }) => name === 'bone').components);
  await after(page, () => parts.selectOption('show=largest'), areDrawn, ['largest']);
  const all = await after(page, () => parts.selectOption('show=all'), areDrawn, ['', 'all']);
  assert.equal(all.digest, hidden.digest);

  await byId('surface-certify-bone').click();
  await byId('surface-certificate-bone').getByText('sound').waitFor();
  await byId('choose-muscle').click();
  const removed = await after(page, () => byId('surface-remove-muscle').click());
  assert.equal(removed.state.surfaces.length, count);
  assert.equal(await byId('surface-muscle').count(), 0);
});

test('a comparison with 1987 draws only what differs, and ends', async () => {
  const before = await settled(page);
  await byId('choose-bone').click();
  const compared = await after(page, () => byId('surface-compare-bone').click());
  assert.ok(compared.state.surfaces.some(each => each.compared_with === 'bone'));
  const ended = await after(page, () => byId('surface-compare-bone').click());
  assert.equal(ended.digest, before.digest);
});

test('light, material, background', async () => {
  await unfold(page);
  const before = { ...await settled(page), ...await state(page) };
  const dot = await middleOf(byId('light-1'));
  const lit = await after(page, () => drag(page, dot, { x: dot.x - 12, y: dot.y + 9 }));
  assert.notDeepEqual(lit.state.lights[0], before.lights[0]);
  const dull = await after(page, () => byId('material-specular').fill('0'),
                           now => now.material.specular === 0);
  const blue = await after(page, () => byId('background').fill('#203050'),
                           now => now.background === '#203050');
  const count = before.lights.length;
  const two = await after(page, () => byId('add-light').click(),
                          (now, count) => now.lights.length === count, count + 1);
  const one = await after(page, () => byId('remove-light').click(),
                          (now, count) => now.lights.length === count, count);
  assert.equal(one.digest, blue.digest);
  const three = await after(page, () => byId('lights-three-point').click(),
                            now => now.lights.length === 3);
  assert.deepEqual(three.state.lights[2],
                   { azimuth_deg: 150, elevation_deg: 35, intensity: 0.6 });
  const again = await after(page, () => byId('undo').click(),
                            (now, count) => now.lights.length === count, count);
  assert.equal(again.digest, blue.digest);
  await after(page, () => byId('lights-three-point').click(), now => now.lights.length === 3);
  const start = await after(page, () => byId('lights-two-point').click(),
                            now => now.lights.length === 2);
  assert.deepEqual(start.state.lights, before.lights);
  assert.equal(new Set([before, lit, dull, blue, two].map(each => each.digest)).size, 5);
});

test('fewer triangles are refused where the GPs have sets of one slab', async () => {
  await byId('detail').selectOption('2');
  await byId('toast-error').getByText('cannot be simplified').waitFor();
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=detail]').value === 'exact');
  assert.equal((await state(page)).detail, 'exact');
});

test('clip planes: add, move, flip, box, remove', async () => {
  const before = await settled(page);
  const halved = await after(page, () => byId('clip-add-L').click(),
                             now => now.clips.length === 1);
  const { plane } = halved.state.clips[0];
  assert.deepEqual(plane.slice(0, 3), [1, 0, 0], "keeps the patient's left, which is +x");
  const moved = await after(page, () => byId('clip-place-L').fill('20'),
                            now => Math.abs(now.clips[0].plane[3] + 20) <= 0.5);
  await byId('clip-flip-L').click();
  await stateWhen(page, now => now.clips[0]?.plane[0] === -1);
  assert.notEqual((await settled(page)).digest, moved.digest);
  await after(page, () => byId('clip-off-R').click(), now => now.clips.length === 0);
  await after(page, () => byId('clip-add-box').click(), now => now.clips.length === 6);
  const open = await after(page, () => byId('clip-off-box').click(), now => now.clips.length === 0);
  assert.equal(open.digest, before.digest);
});

test('undo and redo step through what was done, a drag is one step', async () => {
  const before = await after(page, () => press('r', 'ArrowLeft'));
  await unfold(page);
  const at = await middleOf(byId('stage'));
  const turned = await after(page, () => drag(page, at, { x: at.x + 60, y: at.y }, { steps: 12 }));
  const dark = await after(page, () => byId('background').fill('#000000'),
                           now => now.background === '#000000');
  assert.equal((await after(page, () => byId('undo').click())).digest, turned.digest);
  assert.equal((await after(page, () => press('Control+z'))).digest, before.digest);
  assert.equal((await after(page, () => press('Control+Shift+z'))).digest, turned.digest);
  assert.equal((await after(page, () => byId('redo').click())).digest, dark.digest);
  assert.equal((await state(page)).redo, null);
});
