// The page's own modules agree with their types, as written in their comments.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import path from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';

const page = fileURLToPath(new URL('../../host/serve/page', import.meta.url));

test('tsc finds nothing wrong in the page', () => {
  const tsc = path.join(process.env.PXPL5_NODE_MODULES, 'typescript/bin/tsc');
  try {
    execFileSync(process.execPath, [tsc, '--project', path.join(page, 'jsconfig.json')],
                   { encoding: 'utf8' });
  } catch (error) {
    assert.fail(error.stdout);
  }
});
