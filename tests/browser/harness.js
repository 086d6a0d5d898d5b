// The set-up of every browser test: a served machine, a browser, and a folder for pictures.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { createInterface } from 'node:readline';
import { after, before } from 'node:test';

/** Where the build put programs and packages; ctest hands them over. */
export const bin = required('PXPL5_BIN_DIR');
const modules = required('PXPL5_NODE_MODULES');
/** Screenshots are kept here. */
export const shots = required('PXPL5_SHOTS_DIR');
mkdirSync(shots, { recursive: true });

const { chromium } = createRequire(path.join(modules, 'here.js'))('playwright-core');

const flags = ['--no-sandbox', '--disable-gpu', '--enable-unsafe-swiftshader', '--disable-quic',
             '--no-first-run', '--disable-background-networking', '--disable-component-update',
             '--disable-sync',
             '--js-flags=--expose-gc'];
/** Chromium without its windows, tabs and menus takes a third less time. */
const EXECUTABLES = ['/usr/bin/chromium-headless-shell', '/usr/bin/chromium',
                     '/usr/bin/google-chrome'];
const MAIN_MODULE = new URL('../../host/serve/page/main.js', import.meta.url).pathname;
/** A step that takes longer hangs: generous, since the computer may have other work. */
const STEP_MS = 30_000;

/** @param {string} name */
function required(name) {
  const value = process.env[name];
  if (!value) throw new Error(`${name} is not set: run this through ctest`);
  return value;
}

/**
 * Starts `pxpl5 serve` and waits until it tells its addresses.
 * @param {string[]} words arguments of serve
 */
export async function serve(...words) {
  const folder = mkdtempSync(path.join(tmpdir(), 'pxpl5-browser-'));
  const child = spawn(path.join(bin, 'pxpl5'),
            ['serve', ...words, '--run-folder', path.join(folder, 'run'), '--allow', folder],
            { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] });
  let errors = '';
  child.stderr.on('data', chunk => { errors = (errors + chunk).slice(-10_000); });
  const ended = new Promise(resolve => child.on('exit', (code, signal) =>
    resolve({ code, signal, errors })));
  const addresses = [];
  for await (const line of createInterface({ input: child.stdout })) {
    const found = /https?:\/\/\S+/.exec(line);
    if (found) addresses.push(found[0]);
    if (line.startsWith('Ctrl-C')) break;  // The last line. A class has one address.
  }
  child.stdout.resume();
  if (addresses.length < 1) {
    throw new Error(`pxpl5 serve ended early: ${JSON.stringify(await ended)}`);
  }
  const [url, watchUrl] = addresses;
  return {
    url, watchUrl, folder, child, ended,
    /** Ctrl-C, and what became of it. */
    async stop() {
      child.kill('SIGINT');
      const how = await ended;
      rmSync(folder, { recursive: true, force: true });
      return how;
    },
  };
}

/**
 * @param {string} [rule]  Of a name that this browser resolves, as `MAP headset.test 127.0.0.1`.
 * @returns a browser without a screen, and without any other host than this one
 */
export async function launchBrowser(rule = '') {
  const executablePath = EXECUTABLES.find(existsSync);
  // No other name is resolved, so that a page which needs another host cannot pass.
  const rules = [rule, 'MAP * ~NOTFOUND', 'EXCLUDE 127.0.0.1'].filter(Boolean).join(', ');
  const browser = await chromium.launch(
    { executablePath, args: [...flags, `--host-resolver-rules=${rules}`] });
  return browser;
}

/**
 * Opens a page and waits until it shows a picture.
 * @param {object} options of the browser's context, such as `viewport` in CSS pixels; `scripts` are
 *   functions or texts that run in the page before its own code, `script` is one of them;
 *   `unbundled` loads the page's modules one by one, so that a test may watch their classes;
 *   `refused` is a pattern of addresses that the browser cannot load
 * @returns `close` fails the test if the page complained: errors in the console or not caught
 */
export async function openPage(browser, url, { script, scripts = [script], unbundled, refused,
                                                      ...options } = {}) {
  const context = await browser.newContext(
    { viewport: { width: 1280, height: 720 }, acceptDownloads: true, ...options });
  context.setDefaultTimeout(STEP_MS);
  for (const each of scripts.filter(Boolean)) {
    await context.addInitScript(typeof each === 'string' ? { content: each } : each);
  }
  if (unbundled) {
    await context.route('**/main.js?*', route => route.fulfill({ path: MAIN_MODULE }));
  }
  if (refused) await context.route(refused, route => route.abort());
  const page = await context.newPage();
  const complaints = [];
  page.on('pageerror', error => complaints.push(String(error.stack)));
  page.on('console', message => {
    if (message.type() === 'error') complaints.push(message.text());
  });
  await page.goto(url);
  // A driver's page soon asks for pictures that fit its panel; that is not a test's own change.
  await page.waitForFunction(() => {
    const stage = document.querySelector('[data-testid=stage]');
    const [width, height] = globalThis.pxpl5?.state?.size ?? [0, 1];
    if (!stage) return false;  // The page of a class, which becomes the viewer.
    const fits = Math.abs(width / height - stage.clientWidth / stage.clientHeight) < 0.02;
    return globalThis.pxpl5?.frames > 0 && (fits || document.body.classList.contains('watcher'));
  }).catch(async error => {
    const said = await page.evaluate(() =>
      ({ ...globalThis.pxpl5, body: document.body.innerText }));
    throw new Error(`${error.message}\n${JSON.stringify(said)}\n${complaints.join('\n')}`);
  });
  const close = async () => {
    await context.close();
    assert.deepEqual(complaints, [], 'what the page complained about');
  };
  return { page, context, complaints, close };
}

/** Keeps a screenshot under a name that the README may show. */
export async function shoot(page, name) {
  await page.screenshot({ path: path.join(shots, `${name}.png`) });
}

/** State that all tests of a file share, created by usePage() or useServer(). */
export let server;
export let browser;
export let page;

/** An element of that page. */
export const byId = id => page.getByTestId(id);

/**
 * Serves to all tests of a file, and stops when they are done.
 * @param {string[]} [words] arguments of serve; few voxels, unless said
 */
export function useServer(words = ['phantom:pelvis', 'resample=96x96x48'], opensPage = false,
                          then) {
  let close;
  before(async () => {
    server = await serve(...words);
    browser = await launchBrowser();
    if (opensPage) ({ page, close } = await openPage(browser, server.url));
    await then?.();
  });
  after(async () => {
    try {
      await close?.();
    } finally {
      await browser?.close();
      const how = await server?.stop();
      assert.equal(how?.code, 0, how?.errors);
    }
  });
}

/**
 * The same, and a page that shows a picture.
 * @param {() => Promise<void>} [then] is done last: hooks of one file do not wait for each other
 */
export function usePage(words, then) {
  useServer(words, true, then);
}
