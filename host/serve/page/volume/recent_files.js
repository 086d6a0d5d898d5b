// The files and folders that were opened from this page, kept by the browser for this server.
import {h} from '../elements/dom.js';
import {say} from '../texts/say.js';

const MOST = 8;
const KEY = `pxpl5.recent ${location.pathname}`;  // A portal has several servers at one host.

/** @returns {string[]} paths on the server, newest first */
export function recentFiles() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? '[]');
    return Array.isArray(kept) ? kept.filter(each => typeof each === 'string').slice(0, MOST) : [];
  } catch {
    return [];  // Storage is off, or another program wrote there.
  }
}

/** @param {string[]} paths */
function keep(paths) {
  try {
    if (paths.length === 0) {
      localStorage.removeItem(KEY);
    } else {
      localStorage.setItem(KEY, JSON.stringify(paths.slice(0, MOST)));
    }
  } catch {
    // Storage is off or full. The list is a convenience only.
  }
}

/**
 * @param {string} path  Of a file or folder on the server that was opened.
 */
export function rememberFile(path) {
  keep([path, ...recentFiles().filter(each => each !== path)]);
}

/**
 * @param {(path: string) => void} open
 */
export function createRecentFiles(open) {
  const cards = h('div', {class: 'chips'});
  const root = h('div', {class: 'recent', role: 'group', 'aria-label': say`Recently opened`,
    'data-testid': 'recent', hidden: true},
    h('div', {class: 'row spread'}, h('p', {class: 'muted'}, say`Recently opened`),
      h('button', {type: 'button', class: 'quiet', 'data-testid': 'recent-clear',
        title: say`This browser forgets these names`, onclick: () => {
          keep([]);
          root.hidden = true;
        }}, say`Clear`)),
    cards);
  return {
    root,
    show: () => {
      const paths = recentFiles();
      root.hidden = paths.length === 0;
      cards.replaceChildren(...paths.map(path => h('button', {type: 'button', class: 'chip',
        title: path, 'data-testid': 'recent-file', onclick: () => open(path)},
        path.replace(/\/+$/, '').split('/').slice(-2).join('/'))));
    },
  };
}
