// The title bar: the open volume, undo and redo, open, save and help.
import {byId, DATA, h, update} from '../elements/dom.js';
import {icon} from '../elements/icons.js';
import {say} from '../texts/say.js';
import {createViewTools, moveToMenu} from './view_tools.js';

/** @typedef {import('../panel/app.js').App} App */

/**
 * @param {App} app
 * @param {import('./keyboard.js').Actions} actions
 * @param {HTMLElement} headset  The button of the headset.
 */
export function createBar(app, actions, headset) {
  const name = h('h1', {...DATA, 'data-testid': 'title-volume'});
  const about = h('span', {class: 'muted about'});
  const undo = h('button', {'data-testid': 'undo', 'aria-label': say`Undo`, onclick: actions.undo},
    icon('undo'), h('span', {class: 'word'}, ` ${say`Undo`}`));
  const redo = h('button', {'data-testid': 'redo', 'aria-label': say`Redo`, onclick: actions.redo},
    icon('redo'), h('span', {class: 'word'}, ` ${say`Redo`}`));
  // On a phone, the icon stands for the word.
  const open = h('button', {'data-testid': 'open-panel', title: say`Open a volume (key O)`,
    'aria-label': say`Open …`, onclick: actions.open}, h('span', {class: 'verb'}, say`Open …`),
  h('span', {class: 'alone'}, icon('open')));
  const save = h('button', {'data-testid': 'save-menu', 'aria-label': say`Save …`,
    title: say`Save a mesh, a picture or the session (key S)`, onclick: actions.save},
  h('span', {class: 'verb'}, say`Save …`), h('span', {class: 'alone'}, icon('save')));
  byId('bar').append(
    h('img', {src: 'icon.svg', alt: '', width: 22, height: 22}),
    h('span', {class: 'row what'}, name, about),
    h('span', {class: 'watching', 'data-testid': 'watching', hidden: true,
      title: say`This address is view-only. To make changes, use the other address that pxpl5
        serve printed.`}, say`View only`),
    h('span', {class: 'grow'}), ...createViewTools(app), undo, redo, open,
    save, headset);
  const help = h('button', {class: 'icon', 'data-testid': 'help', 'aria-label': say`Help`,
    title: say`Help (key ?)`, onclick: actions.help}, '?');
  moveToMenu('phone', say`Help`, help, () => byId('bar').append(help));
  app.store.subscribe(['volume', 'archive', 'machine'], ({volume, archive, machine}) => {
    name.textContent = volume?.name ?? archive ?? say`No volume`;
    document.title = `${name.textContent} · pxpl5`;
    about.textContent = volume ? [volume.modality, volume.size.join(' × '),
      say`${machine.gps} GPs, ${machine.renderers} Renderers`].filter(Boolean).join(' · ') : '';
    about.title = volume?.source ?? '';
  });
  app.history.watch(() => {
    const [back, again] = [app.history.title('undo'), app.history.title('redo')];
    undo.toggleAttribute('disabled', back === null);
    redo.toggleAttribute('disabled', again === null);
    update(undo, {title: back ? say`Undo: ${back} (key U)` : say`Nothing to undo`});
    update(redo, {title: again ? say`Redo: ${again} (key shift U)` : say`Nothing to redo`});
  });
  app.connection.on('hello', ({role}) => {
    byId('bar').querySelector('.watching')?.toggleAttribute('hidden', role !== 'watcher');
    open.disabled = role === 'watcher';
    save.disabled = role === 'watcher';
  });
}
