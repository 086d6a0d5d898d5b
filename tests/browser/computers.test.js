// The computers of a machine in the page. All of them are this one, by the engine `command`.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from './harness.js';
import { errorsShown, settled } from './steps.js';

const BY_COMMAND = ['env', 'COMPUTER={computer}', '{join}']
  .flatMap(word => ['--set', `engine_command=${word}`]);

usePage(['phantom:sphere', '--engine', 'command', ...BY_COMMAND, '--set', 'listen=127.0.0.1',
         '--computers', 'a:4,b:4', '--set', 'placement=spread']);

const textOf = name => byId(`computer-${name}`).innerText();

/** Presses a button of a computer, and waits for what its row says then. */
async function press(name, button, expected) {
  await byId(`computer-${name}`).getByRole('button', { name: button }).click();
  await byId(`computer-${name}`).getByText(expected).waitFor();
}

test('a computer is released and used again, and the picture is the same', async () => {
  await byId('tab-machine').click();
  await byId('computer-a').waitFor();
  assert.match(await textOf('a'), /^a used, \d+ cores?, [1-9]\d* nodes?/);
  assert.match(await textOf('b'), /^b used, \d+ cores?, [1-9]\d* nodes?/);
  const { digest } = await settled(page);
  assert.match(digest, /^[0-9a-f]{16}$/);
  await byId('computers').scrollIntoViewIfNeeded();
  await shoot(page, 'computers');

  await press('b', 'Release', /released, \d+ cores?, 0 nodes/);
  assert.equal(await byId('computer-b').getByRole('button', { name: 'Release' }).count(), 0);
  assert.equal((await settled(page)).digest, digest);

  await press('b', 'Use', /used, \d+ cores?, [1-9]\d* nodes?/);
  assert.equal((await settled(page)).digest, digest);
  assert.deepEqual(await errorsShown(page), []);
});

test('an invitation is the command for one more computer', async () => {
  await byId('computers-invite').click();
  await byId('invitation').getByText('pxpl5 join tcp://127.0.0.1:').waitFor();
  assert.match(await byId('invitation').innerText(), /--key-file \S+/);
});

test('a viewer that only watches sees no buttons for computers', async () => {
  const watcher = await openPage(browser, server.watchUrl);
  await watcher.page.getByTestId('tab-machine').click();
  await watcher.page.getByTestId('nodes').waitFor();
  assert.equal(await watcher.page.getByTestId('computers-invite').isVisible(), false);
  await watcher.close();
});
