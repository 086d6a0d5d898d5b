// The tour of the machine: each step by its address and by keys, with the numbers that the machine
// gives to `why`; after a change of the scene; in a narrow window; on a view-only page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { lookFor } from '../layout.js';
import { after, ask, rawSocket, say, settled, state } from '../steps.js';

const STEPS = 6;
const axe = readFileSync(path.join(process.env.PXPL5_NODE_MODULES, 'axe-core/axe.min.js'), 'utf8');

useServer(['phantom:pelvis', 'resample=96x96x48']);

/** A text as HTML shows it. */
const shown = text => text.replace(/\s+/g, ' ');

/** A number as the page writes it. */
const written = number => String(number).replace(/\B(?=(\d{3})+(?!\d))/g, ',');

/** Opens a page at an address of the tour, with its messages: `lines` sent, `reports` received. */
async function openTour(t, hash, options = {}, url = server.url) {
  const opened = await openPage(browser, `${url}${hash}`, { ...options, scripts: [axe, listen] });
  let isClosed = false;
  const close = async () => {
    isClosed = true;
    await opened.close();
  };
  t.after(async () => { if (!isClosed) await opened.context.close(); });
  const heard = { lines: () => opened.page.evaluate(() => globalThis.heard.lines),
                  reports: () => opened.page.evaluate(() => globalThis.heard.reports) };
  return { ...opened, heard, close, id: name => opened.page.getByTestId(name) };
}

/** In the page, before its code: keeps command lines, reports of the machine, and what was said. */
function listen() {
  globalThis.heard = { lines: [], reports: [], said: [] };
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function sendAndKeep(data) {
    const message = JSON.parse(data);
    if (message.do) globalThis.heard.lines.push(message.do);
    if (!this.isHeard) {
      this.isHeard = true;
      this.addEventListener('message', ({ data: text }) => {
        if (typeof text === 'string' && text.startsWith('{"machine"')) {
          globalThis.heard.reports.push(JSON.parse(text).machine);
        }
      });
    }
    send.call(this, data);
  };
  document.addEventListener('DOMContentLoaded', () => {
    new MutationObserver(() => {
      const said = document.querySelector('[data-testid=tour-message]')?.textContent;
      if (said && globalThis.heard.said.at(-1) !== said) globalThis.heard.said.push(said);
    }).observe(document.body, { subtree: true, childList: true, characterData: true });
  });
}

/** Waits until the step has all its answers; returns its text. */
async function answered(page, step) {
  await page.waitForFunction(step => {
    const part = name => document.querySelector(`[data-testid=tour-${name}]`);
    return part('count')?.textContent.includes(`step ${step} of`) &&
      part('message').textContent === '' && !part('text').classList.contains('outdated');
  }, step).catch(async error => {
    const found = await page.evaluate(() => {
      const { state, revision, rests, frames } = globalThis.pxpl5;
      const message = document.querySelector('[data-testid=tour-message]')?.textContent;
      return { message, scene: state.revision, busy: state.busy, revision, rests, frames,
               lines: globalThis.heard.lines };
    });
    throw new Error(`step ${step} has no answer: ${JSON.stringify(found)}\n${error.message}`);
  });
  return page.getByTestId('tour-text').innerText();
}

/** What the machine says about the pixel that the page asked for last. */
async function whyOf(tour, raw) {
  const line = (await tour.heard.lines()).findLast(each => each.startsWith('why '));
  const { ok, result, error } = await say(raw, line);
  assert.ok(ok, error);
  return result;
}

/** Asserts that the text has all of these. */
function hasAll(text, wanted) {
  for (const each of wanted) assert.ok(text.includes(each), `'${each}' in: ${text}`);
}

/** What each step must say, of the machine's own answers. */
const CHECKS = [
  async (text, { why }) => {
    const { cell, surface } = why.visits[why.shown];
    const { isovalue } = why.surfaces[surface];
    const inside = cell.values.filter(value => value >= isovalue).length;
    hasAll(text, [`Pixel (${why.x}, ${why.y})`, `cell ${cell.cell.join(', ')}.`,
      `${inside} of its 8 voxels`, `isovalue, ${isovalue}`, `Case ${cell.case} `,
      `gives ${cell.triangle_count} triangle`, '48 slices of 96 × 96']);
  },
  async (text, { why, now }) => {
    const { gp, slab } = why.visits[why.shown];
    const triangles = now.surfaces.filter(({ visible }) => visible)
      .reduce((sum, each) => sum + each.triangles, 0);
    const [columns, rows] = now.size.map(pixels => Math.ceil(pixels / 128));
    hasAll(text, [`gp-${gp} `, `slab ${slab}.`, `${written(triangles)} triangles`,
      `${columns} × ${rows} regions`, `region ${why.region}.`,
      `have ${written(why.primitives_in_region)} triangles`, `. ${why.visits.length} of them`]);
  },
  async (text, { why, raw, tour }) => {
    const [{ at, instruction }] = why.visits[why.shown].writes;
    const { json } = await ask(raw, { ask: 'scrub', x: why.x, y: why.y, at });
    hasAll(text, [`region ${why.region} has ${written(json.count)} instructions`,
      `renderer-${why.renderer} executes`, `instruction ${written(at)}: “${shown(instruction)}”`]);
    const now = tour.id('disassembly').locator('li.now code');
    await now.getByText(instruction, { exact: true }).waitFor();
  },
  async (text, { why, raw, tour }) => {
    const visit = why.visits[why.shown];
    const { at, instruction } = visit.writes.find(({ before, after }) => before.z !== after.z);
    const { json } = await ask(raw, { ask: 'scrub', x: why.x, y: why.y, at });
    const [a, b, c] = instruction.split(/\s+/).slice(-3).map(Number);
    const [x, y] = [why.x - json.x0, why.y - json.y0];
    hasAll(text, [`Instruction ${written(at)} writes`, `A = ${written(a)}, `, `B = ${written(b)}, `,
      `C = ${written(c)}.`, `x = ${x}, y = ${y}`, ` ${written(a * x + b * y + c)}.`,
      `depth ${written(visit.z)}.`]);
    await tour.page.getByText(`Now ${written(json.enabled)} pixel`).waitFor();
    await tour.id('disassembly').locator('li.now code').getByText(instruction, { exact: true })
      .waitFor();
  },
  async (text, { why, tour }) => {
    const told = /, renderer-(\d+) sent ([\d,]+) messages? RegionPixels with ([\d,]+) bytes/
      .exec(text);
    assert.ok(told, text);
    assert.equal(Number(told[1]), why.renderer);
    const [messages, bytes] = told.slice(2).map(each => Number(each.replaceAll(',', '')));
    const sums = (await tour.heard.reports()).map(({ nodes, frame, channels }) => {
      const sent = nodes.find(({ name }) => name === `renderer-${why.renderer}`).sent
        .filter(({ kind }) => kind === 'RegionPixels');
      const sum = what => sent.reduce((all, each) => all + each[what], 0);
      return { messages: sum('messages'), bytes: sum('bytes'), nodes: nodes.length,
               channels: channels.length, cycles: frame?.regions.cycles[why.region] };
    });
    const found = sums.find(sum => sum.messages === messages && sum.bytes === bytes);
    assert.ok(found && messages > 0, `${text}\n${JSON.stringify(sums)}`);
    hasAll(text, [`${found.nodes} nodes`, `${found.channels} channels`,
      `Region ${why.region} took ${written(found.cycles)} cycles`,
      `${Number((found.cycles / 40e3).toPrecision(3))} ms`]);
  },
  async (text, { raw }) => {
    const { result } = await say(raw, 'model');
    hasAll(text, [`${result.gps} GPs`, `${result.renderers} Renderers`,
      ` ${Number(result.frame.frames_per_s.toPrecision(3))} times per second`,
      ` ${Number(result.frame.latency_ms.toPrecision(3))} ms`]);
  },
];
/** The panel of each step, and what must be seen of it. */
const OPENED = [['inspector', 'why-cell'], ['inspector', 'why-triangle'], ['inspector', 'stream'],
  ['inspector', 'stream'], ['machine', 'ring'], ['machine', 'model-facts']];

/** Checks the step that a page shows: numbers, panel, and what is in sight. */
async function check(tour, raw, step) {
  const text = await answered(tour.page, step);
  await settled(tour.page);
  const why = step < STEPS ? await whyOf(tour, raw) : null;
  await CHECKS[step - 1](text, { why, raw, tour, now: await state(tour.page) });
  const [panel, part] = OPENED[step - 1];
  assert.equal(await tour.id(`tab-${panel}`).getAttribute('aria-selected'), 'true');
  const box = await tour.id(part).boundingBox();
  const card = await tour.id('tour').boundingBox();
  const { height } = tour.page.viewportSize();
  assert.ok(box.y < height - 20 && box.y + box.height > card.y + card.height,
            `step ${step}: ${JSON.stringify(box)}`);
}

for (let step = 1; step <= STEPS; step++) {
  test(`the address of step ${step} opens it in a fresh page, with the machine's own numbers`,
       async t => {
    const tour = await openTour(t, `#tour=${step}`);
    const raw = await rawSocket(tour.page, server.url);
    await check(tour, raw, step);
    assert.equal(new URL(tour.page.url()).hash, `#tour=${step}`);
    await shoot(tour.page, `tour-${step}`);
    await tour.close();
  });
}

test('with keys alone: T opens, Enter goes on, Esc closes and gives the focus back', async t => {
  const tour = await openTour(t, ''), { page, id } = tour;
  const raw = await rawSocket(page, server.url);
  await id('stage').focus();
  await page.keyboard.press('t');
  await id('tour-title').waitFor();
  const focus = () => page.evaluate(() => document.activeElement.dataset.testid);
  assert.equal(await focus(), 'tour-title');
  for (let presses = 0; await focus() !== 'tour-next'; presses++) {
    assert.ok(presses < 20, 'Tab reaches the button');
    await page.keyboard.press('Tab');
  }
  for (let step = 1; step <= STEPS; step++) {
    await check(tour, raw, step);
    assert.equal(await id(`tour-link-${step}`).getAttribute('aria-current'), 'step');
    if (step < STEPS) await page.keyboard.press('Enter');
  }
  await page.goBack();
  await answered(page, STEPS - 1);
  await page.keyboard.press('Escape');
  await id('tour').waitFor({ state: 'hidden' });
  assert.equal(new URL(page.url()).hash, '');
  assert.equal(await focus(), 'stage');
  await page.keyboard.press('t');
  await id('tour').waitFor();
  await id('stage').focus();
  await page.keyboard.press('Escape');
  await id('tour').waitFor({ state: 'hidden' });
  await tour.close();
});

test('a step says that the scene has changed, and asks again', async t => {
  const tour = await openTour(t, '#tour=1'), { page } = tour;
  const raw = await rawSocket(page, server.url);
  await answered(page, 1);
  await say(raw, 'surface bone iso=300.5');
  await page.getByTestId('tour-text').getByText('the isovalue, 300.5').waitFor();
  await check(tour, raw, 1);
  const said = await page.evaluate(() => globalThis.heard.said);
  assert.ok(said.some(each => each.startsWith('The picture has changed.')), said.join('\n'));
  await say(raw, 'surface bone iso=250.5');
  await page.getByTestId('tour-text').getByText('the isovalue, 250.5').waitFor();
  await page.getByTestId('tour-link-6').click();
  await check(tour, raw, 6);
  await after(page, () => say(raw, 'view 40 10'));
  await check(tour, raw, 6);
  await after(page, () => say(raw, 'view anterior'));
  await tour.close();
});

test('the tour follows the pixel that is asked for, and its address keeps the pixel', async t => {
  const tour = await openTour(t, '#tour=2'), { page, id } = tour;
  const raw = await rawSocket(page, server.url);
  await answered(page, 2);
  await settled(page);
  const { size } = await state(page);
  await id('why-x').fill(String(Math.floor(size[0] / 2) - 60));
  await id('why-y').fill(String(Math.floor(size[1] / 2) - 40));
  await id('why-ask').click();
  await page.waitForFunction(() => location.hash.includes('pixel='));
  await check(tour, raw, 2);
  const line = (await tour.heard.lines()).findLast(each => each.startsWith('why '));
  const pixel = line.split(' ').slice(1);
  assert.equal(new URL(page.url()).hash, `#tour=2&pixel=${pixel}`);
  const { hash } = new URL(await id('tour-link-4').evaluate(link => link.href));
  const fresh = await openTour(t, hash);
  await check(fresh, raw, 4);
  assert.equal((await fresh.heard.lines()).findLast(each => each.startsWith('why ')), line);
  await fresh.close();
  await tour.close();
  const outside = await openTour(t, '#tour=1&pixel=9000,9000');
  await outside.id('tour-message').getByText('outside of the picture').waitFor();
  await outside.id('tour-text').getByText('shows the cell').waitFor();
  await outside.close();
});

test('the tour keeps the pixel that is asked for, though its own answer comes later', async t => {
  const tour = await openTour(t, '#tour=2'), { page, id } = tour;
  await answered(page, 2);
  await settled(page);
  await page.evaluate(() => document.addEventListener('explained', event => {
    if (event.detail.by === 'user') globalThis.explained = event.detail;
  }));
  const { size } = await state(page);
  await id('why-x').fill(String(Math.floor(size[0] / 2) - 60));
  await id('why-y').fill(String(Math.floor(size[1] / 2) - 40));
  await id('why-ask').click();
  await page.waitForFunction(() => globalThis.explained);
  await answered(page, 2);
  const { hash } = new URL(page.url());
  const lines = await tour.heard.lines();
  await page.evaluate(() => {
    const { result } = globalThis.explained;
    const other = { ...globalThis.explained, by: 'tour', result: { ...result, x: result.x + 9 } };
    document.dispatchEvent(new CustomEvent('explained', { detail: other }));
  });
  await page.waitForFunction(least => globalThis.heard.lines.length > least, lines.length);
  await answered(page, 2);
  const line = lines.findLast(each => each.startsWith('why '));
  assert.equal((await tour.heard.lines()).at(-1), line);
  assert.equal(new URL(page.url()).hash, hash);
  await tour.close();
});

test('without a surface the tour says so, and goes on when one is shown', async t => {
  const tour = await openTour(t, '#tour=1'), { page, id } = tour;
  const raw = await rawSocket(page, server.url);
  await answered(page, 1);
  for (const name of ['bone', 'skin']) await say(raw, `surface ${name} visible=no`);
  await id('tour-message').getByText('found no surface').waitFor();
  for (const name of ['bone', 'skin']) await say(raw, `surface ${name} visible=yes`);
  await check(tour, raw, 1);
  await tour.close();
});

for (const viewport of [{ width: 1280, height: 720 }, { width: 390, height: 844 },
  { width: 960, height: 540 }]) {
  test(`at ${viewport.width} px: every step is in sight, in reach, and passes axe`, async t => {
    const tour = await openTour(t, '#tour=1', { viewport }), { page, id } = tour;
    const raw = await rawSocket(page, server.url);
    for (let step = 1; step <= STEPS; step++) {
      await check(tour, raw, step);
      await shoot(page, `tour-${viewport.width}-${step}`);
      const { violations } = await page.evaluate(() =>
        globalThis.axe.run('#tour', { preload: false }));
      assert.deepEqual(violations.map(each => [each.id, each.nodes.map(node => node.html)]), []);
      assert.deepEqual(await page.evaluate(lookFor.misplaced), [], `step ${step}`);
      assert.deepEqual(await page.evaluate(lookFor.faintText), [], `step ${step}`);
      if (step < STEPS) await id('tour-next').click();
    }
    await tour.close();
  });
}

test('a view-only page takes the tour as far as it can ask', async t => {
  const driver = await openTour(t, '');
  const raw = await rawSocket(driver.page, server.url);
  const tour = await openTour(t, '#tour=1', {}, server.watchUrl), { page, id } = tour;
  await id('tour-text').getByText('48 slices of 96 × 96').waitFor();
  assert.equal(await id('tab-slices').getAttribute('aria-selected'), 'true');
  for (let step = 1; step <= STEPS; step++) {
    await id('tour-message').getByText('A view-only page cannot ask').waitFor();
    if (step < STEPS) await id('tour-next').click();
  }
  // The step does not use its first report, which counts from long before it began.
  await page.waitForFunction(() => globalThis.heard.reports.length > 0);
  await id('tour-link-5').click();
  await id('tour-count').getByText(`step 5 of ${STEPS}`).waitFor();
  const before = (await tour.heard.reports()).length;
  await page.waitForFunction(was => globalThis.heard.reports.length > was, before);
  await after(driver.page, () => say(raw, 'view 20 5'));
  await id('tour-text').getByText(/the Renderers sent [\d,]+ messages? RegionPixels/).waitFor();
  await id('tour-link-3').click();
  await id('tour-text').getByText(/executed [\d,]+ instructions/).waitFor();
  const told = await id('tour-text').innerText();
  const counts = (await tour.heard.reports()).map(({ frame }) => frame?.instructions);
  assert.ok(counts.some(count => told.includes(`executed ${written(count)} instr`)), told);
  assert.deepEqual(await tour.heard.lines(), []);
  await tour.close();
  await driver.close();
});
