// One way to write numbers: commas between thousands, a space before units, and ² not 2. Every
// text that the page shows of a scene is read, in all panels, with those of canvases.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { browser, openPage, server, useServer } from '../harness.js';
import { drag, middleOf, settled, unfold } from '../steps.js';

const PAGE = new URL('../../../host/serve/page/', import.meta.url).pathname;

useServer(['phantom:pelvis']);

/** In the page, before its code: keeps the texts that canvases show. */
function keepCanvasTexts() {
  globalThis.painted = new Set();
  const fillText = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function fillAndKeep(text, ...rest) {
    globalThis.painted.add(String(text));
    return fillText.call(this, text, ...rest);
  };
}

/**
 * In the page: all texts, tooltips, and names for screen readers. Instructions, addresses and
 * digests are code, and no numbers.
 */
function textsShown() {
  const texts = [...globalThis.painted];
  for (const element of document.body.querySelectorAll('*')) {
    for (const name of ['title', 'aria-label', 'aria-valuetext']) {
      const text = element.getAttribute(name);
      if (text && !element.closest('.disassembly')) texts.push(text);
    }
    const own = [...element.childNodes].filter(node => node.nodeType === Node.TEXT_NODE)
      .map(node => node.textContent).join('').trim();
    if (own && !element.closest('code, script, .meaning, .effect, [data-testid=title-volume]')) {
      texts.push(own);
    }
  }
  return texts;
}

/** What is wrong with the numbers of a text; '' if nothing is. */
function fault(text) {
  const read = text.replace(/“[^”]*”/g, '')         // A quoted instruction.
    .replace(/#[0-9a-f]{6}\b|0x[0-9a-f]+/gi, '')    // A color.
    .replace(/\b\d{1,4}( [×x] \d{1,4})+/g, '')      // A size of a grid or a picture.
    .replace(/\(\d{1,4}, \d{1,4}\)/g, '')           // A pixel.
    .replace(/\b(1987|1989|1993)\b/g, '');          // A year.
  if (/(?<![\d.,])\d{4,}/.test(read)) return 'no comma between thousands';
  if (/\d[ \u00a0\u2009\u202f']\d{3}(?!\d)/.test(read)) return 'thousands not grouped by a comma';
  if (/\b[mck]m[23]\b/.test(read)) return 'a digit as an exponent';
  if (/\d(mm|cm|ms|ml|MB|kB|MHz|%|HU|fps)(?![a-z])/.test(read)) return 'no space before the unit';
  if (/\d\.\d{7,}|\de[+-]\d|NaN|undefined|Infinity/.test(read)) return 'an unrounded number';
  return '';
}

test('the check of texts finds each wrong form, and none in right ones', () => {
  for (const wrong of ['48884 triangles', '42 900 triangles', '42\u202f900', '12 mm2', '3cm²',
    '0.30000000000000004', '95% busy', '12mm', 'from 1000 to 20000']) {
    assert.notEqual(fault(wrong), '', wrong);
  }
  for (const right of ['48,884 triangles', '-1,000', '12 mm²', '3.5 cm²', '95 %', '512 × 512 × 275',
    'Pixel (1024, 20)', '#867464', 'the machine of 1993', 'slices 2, 900 of them', '1.25 mm']) {
    assert.equal(fault(right), '', right);
  }
});

test('all panels of the page write numbers in one way', async t => {
  const { page, context, complaints } = await openPage(browser, server.url,
                                                       { script: keepCanvasTexts });
  t.after(() => context.close());
  const id = name => page.getByTestId(name);
  const seen = new Set();
  const read = async () => {
    const texts = await page.evaluate(textsShown);
    texts.forEach(text => seen.add(text));
    const found = texts.map(text => [fault(text), text]).filter(([what]) => what !== '');
    assert.deepEqual(found, []);
  };
  await settled(page);
  await unfold(page);
  await id('surface-certify-skin').click();
  const report = id('surface-certificate-skin').locator('.report');
  await report.first().waitFor({ state: 'attached' });
  await unfold(page);
  assert.match(await report.first().innerText(), /42,900 triangles.* mm²/s);
  await read();
  const stage = await middleOf(id('stage'));
  await page.mouse.click(stage.x, stage.y - 30);
  await id('pointed').waitFor();
  await read();
  for (const step of [1, 2, 3, 4, 5, 6]) {
    await page.evaluate(step => { location.hash = `tour=${step}`; }, step);
    await page.waitForFunction(step => {
      const part = name => document.querySelector(`[data-testid=tour-${name}]`).textContent;
      return part('count').includes(`step ${step} of`) && part('message') === '';
    }, step);
    await unfold(page);
    await read();
  }
  await id('tour-close').click();
  await drag(page, stage, { x: stage.x + 60, y: stage.y + 10 }, { steps: 20 });
  await id('clocks').getByText('1993').waitFor();
  await read();
  await id('node-gp-0').click();
  await id('node-status').getByText(/In the last [0-9.]+ s/).waitFor();
  await read();
  await id('node-close').click();
  await id('tab-volume').click();
  await read();
  await id('tab-slices').click();
  await id('choice-measure').click();
  await settled(page);
  const slice = await middleOf(id('slice-axial'));
  for (const dx of [-30, 30]) await page.mouse.click(slice.x + dx, slice.y);
  await id('slices-message').getByText(' mm').waitFor();
  await read();
  await id('tab-measure').click();
  await read();
  for (const wanted of [/^\d{2},\d{3} triangles/, /[\d,]+ of [\d,]+ instructions/, /cycles/,
    / mm$/, / HU/, / frames\/s/, / %/]) {
    assert.ok([...seen].some(text => wanted.test(text)), `no text like ${wanted}`);
  }
  assert.deepEqual(complaints, []);
});

test('one file of the page makes texts of numbers', () => {
  // Rounding may stand in what is no text: commands, coordinates of drawings, fields.
  const drawings = ['link/lines.js', 'shell/overlay.js', 'machine/node_list.js',
    'inspect/cell_view.js', 'surfaces/histogram.js',
    'surfaces/surface_card.js', 'slices/window_controls.js', 'surfaces/axis.js'];
  const files = readdirSync(PAGE, { recursive: true }).filter(name => name.endsWith('.js'));
  assert.ok(files.length > 60, `${files.length} files`);
  for (const name of files.filter(each => each !== 'elements/numbers.js')) {
    const text = readFileSync(path.join(PAGE, name), 'utf8');
    assert.ok(!/\.toLocaleString\(|NumberFormat/.test(text),
              `${name} groups digits by itself, not with elements/numbers.js`);
    assert.ok(!/\.(toFixed|toPrecision)\(/.test(text) || drawings.includes(name),
              `${name} rounds by itself, not with elements/numbers.js`);
  }
});
