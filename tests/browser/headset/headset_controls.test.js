// The controllers of an emulated headset (IWER): grab, cut, isovalue, lengths, recentering.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, page, server, shoot, usePage } from '../harness.js';
import { after, say, socketWithoutSkin, state, stateWhen } from '../steps.js';
import { figures, figuresWhen, leftView, settledPair, worn } from './emulated.js';

const DISTANCE_M = 0.8;        // The page puts the patient there.

let raw;

usePage(['phantom:pelvis', 'resample=96x96x48'], async () => {
  raw = await socketWithoutSkin(page, server.url);
});

const wornHere = act => worn(browser, server.url, act);

/** Millimeters of the patient per meter of the room: what is too large for the room is scaled. */
async function mmPerMeter(page) {
  return Math.max(1000, 2 * (await state(page)).camera.radius_mm / 0.6);
}

/** Presses or releases a button of the right controller, and waits for frames. */
async function press(page, button, value) {
  await page.evaluate(([button, value]) =>
    globalThis.headset.controllers.right.updateButtonValue(button, value), [button, value]);
  const { frames } = await figures(page);
  await figuresWhen(page, (now, frames) => now.frames > frames + 2, frames);
}

/** Moves the right controller in steps, a frame each. */
function moveHand(page, from, to, steps = 5) {
  return page.evaluate(async ({ from, to, steps }) => {
    const { position } = globalThis.headset.controllers.right;
    for (let step = 0; step <= steps; step++) {
      position.set(...from.map((each, k) => each + (to[k] - each) * step / steps));
      const { frames } = globalThis.pxpl5.headset;
      while (globalThis.pxpl5.headset.frames < frames + 2) {
        await new Promise(requestAnimationFrame);
      }
    }
  }, { from, to, steps });
}

test('grip: the patient is in the hand; A and the headset put it before the viewer again', () =>
  wornHere(async page => {
    const was = await leftView(page);
    const grab = async () => {
      await moveHand(page, [0.2, 1.2, -0.6], [0.2, 1.2, -0.6]);
      await press(page, 'squeeze', 1);
      await moveHand(page, [0.2, 1.2, -0.6], [0.4, 1.2, -0.6]);
      await press(page, 'squeeze', 0);
      await settledPair(page);
      return leftView(page);
    };
    const held = await grab();
    assert.ok(Math.abs((held.x - was.x) / (0.2 / DISTANCE_M) - 1) < 0.2, `${was.x} ${held.x}`);
    await press(page, 'a-button', 1);
    await press(page, 'a-button', 0);
    await settledPair(page);
    const home = await leftView(page);
    assert.ok(Math.abs(home.x - was.x) < 0.02, `${was.x} ${home.x}`);
    await grab();
    await page.evaluate(() => globalThis.headset.recenter());
    await settledPair(page);
    const again = await leftView(page);
    assert.ok(Math.abs(again.x - was.x) < 0.02, `${was.x} ${again.x}`);
  }));

test('trigger: a plane is held, and goes when it is pulled out', () => wornHere(async page => {
  await moveHand(page, [0, 1.2, -0.6], [0, 1.2, -0.6]);
  await press(page, 'trigger', 1);
  await moveHand(page, [0, 1.2, -0.6], [0, 1.2, -0.7]);
  await press(page, 'trigger', 0);
  // It points away from the viewer, who sees the patient from before: the posterior part stays.
  const now = await stateWhen(page, now => now.clips.length === 1);
  const [letter, at] = now.clips[0].words.split(' ');
  assert.equal(letter, 'P');
  // The tip is 8 cm before the hand, 2 cm nearer than the center.
  const wanted = now.camera.center_mm[1] - 0.02 * await mmPerMeter(page);
  await stateWhen(page, (now, wanted) =>
    Math.abs(Number(now.clips[0]?.words.split(' ')[1]) - wanted) < 1, wanted)
    .catch(() => assert.fail(`clip at ${at}, not at ${wanted}`));
  await settledPair(page);
  await shoot(page, 'headset-clip');
  await press(page, 'trigger', 1);
  await moveHand(page, [0, 1.2, -0.7], [0, 1.2, -0.2]);
  await press(page, 'trigger', 0);
  await stateWhen(page, now => now.clips.length === 0);
}));

test('stick: the isovalue of the chosen surface; one step to undo', () => wornHere(async page => {
  const bone = now => now.surfaces.find(({ name }) => name === 'bone').isovalue;
  await page.evaluate(() => [...document.querySelectorAll('.surface .name')]
    .find(each => each.textContent === 'bone').click());
  const tilt = y => page.evaluate(y =>
    globalThis.headset.controllers.right.updateAxes('thumbstick', 0, y), y);
  const raiseAbove = async value => {
    await tilt(-1);
    await stateWhen(page, (now, wanted) =>
      now.surfaces.some(({ name, isovalue }) => name === 'bone' && isovalue > wanted), value);
    await tilt(0);
    await settledPair(page);
  };
  const before = bone(await state(page));
  await raiseAbove(before + 50);
  const middle = bone(await state(page));
  await raiseAbove(middle + 200);
  // Undoes the second tilt, and not the first. Its last setting may have come after `middle`.
  await say(raw, 'undo');
  await stateWhen(page, (now, [low, high]) =>
    now.surfaces.some(({ name, isovalue }) => name === 'bone' && isovalue > low &&
      isovalue < high), [before + 50, middle + 200]);
}));

test('B at two places: their distance, in the list of the page, too', () => wornHere(async page => {
  const place = async at => {
    await moveHand(page, at, at);
    await press(page, 'b-button', 1);
    await press(page, 'b-button', 0);
  };
  await place([0, 1.2, -0.6]);
  await place([0.1, 1.2, -0.6]);
  const listed = page.locator('#panels .distances b').first();  // Two tabs have the list.
  const [length] = /\d+(?= mm)/.exec(await listed.textContent());
  assert.ok(Math.abs(Number(length) - 0.1 * await mmPerMeter(page)) <= 0.6, length);
  await shoot(page, 'headset-length');
}));
