// Fewer triangles and stereo: chosen in the page, drawn, and one exact picture again.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, shoot, usePage } from './harness.js';
import { after, errorsShown, settled, state, unfold } from './steps.js';

usePage(['phantom:pelvis', 'resample=128x128x96', '--set', 'gp.slabs_per_set=16']);

const choose = word => after(page, () => byId('detail').selectOption(word),
                             (now, word) => now.detail === word, word);
const quality = () => byId('badge-quality').textContent();

test('fewer triangles, and all again', async () => {
  await unfold(page);
  const exact = await settled(page);
  assert.equal((await state(page)).detail, 'exact');
  assert.doesNotMatch(await quality(), /simplified/);

  const seen = [exact.digest];
  const bounds = [];
  for (const detail of ['1', '2', '3']) {
    seen.push((await choose(detail)).digest);
    const [, mm] = /^simplified within ([0-9.]+) mm$/.exec(await quality());
    bounds.push(Number(mm));
    await shoot(page, `detail-${detail}`);
  }
  assert.equal(new Set(seen).size, 4, 'each choice shows');
  assert.ok(bounds[0] > 0 && bounds[0] < bounds[1] && bounds[1] < bounds[2], bounds.join());
  assert.doesNotMatch(await byId('badge-quality').getAttribute('class'), /good/);

  assert.equal((await choose('auto')).digest, exact.digest, 'at rest all triangles are drawn');
  assert.doesNotMatch(await quality(), /simplified/);
  assert.equal((await choose('exact')).digest, exact.digest);
  assert.match(await byId('badge-quality').getAttribute('class'), /good/);
  assert.deepEqual(await errorsShown(page), []);
});

test('an anaglyph, and one camera again', async () => {
  const before = await settled(page);
  const stereo = word => after(page, () => byId('stereo').selectOption(word),
                               (now, word) => now.stereo === word, word);
  const pair = await stereo('anaglyph');
  assert.notEqual(pair.digest, before.digest);
  await shoot(page, 'stereo-anaglyph-1280');
  assert.equal((await stereo('off')).digest, before.digest);
  assert.deepEqual(await errorsShown(page), []);
});
