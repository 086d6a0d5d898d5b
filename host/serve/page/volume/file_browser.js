// The folders of the server's computer that the page may read, as a list in the dialog Open.
import {DATA, h, setText} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {plural, say} from '../texts/say.js';
import {dateText, sizeText} from './words.js';

/** @typedef {import('../panel/app.js').App} App */
/**
 * An entry of the answer `folder`.
 * @typedef {{name: string, path: string, is_folder: boolean, kind: string, bytes: number | null,
 *   modified_s: number | null}} Entry
 */
/**
 * @typedef {{path: string, above: string | null, entries: Entry[], more: number,
 *   other_files: number, links_out: number, odd_names: number, is_whole: boolean}} Listing
 */

/** Rows that Page Up and Page Down pass. */
const PAGE_ROWS = 8;
const FIND_WAIT_MS = 150;
/** Kinds of files that are no names of formats. */
const KINDS = new Map([['NIfTI header', say`NIfTI header`], ['archive', say`archive`],
  ['no suffix', say`no suffix`], ['', say`other`]]);

/**
 * @param {App} app
 * @param {object} acts
 * @param {(path: string) => void} acts.pick  The user has gone to this file or folder.
 * @param {() => void} acts.open  Opens what was picked last.
 */
export function createFileBrowser(app, acts) {
  const browser = new FileBrowser(app, acts);
  return {root: browser.root, show: () => browser.show()};
}

class FileBrowser {
  /**
   * @param {App} app
   * @param {{pick: (path: string) => void, open: () => void}} acts
   */
  constructor(app, acts) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.acts_ = acts;
    /** @private The folder of the list; '' for the list of allowed folders. */
    this.path_ = '';
    /** @private @type {Listing | null} */
    this.listing_ = null;
    /** @private Index of the chosen row; -1: none. */
    this.at_ = -1;
    /** @private Number of the newest question. */
    this.asked_ = 0;
    /** @private */
    this.findTimer_ = 0;
    /** @private */
    this.list_ = h('ul', {class: 'listing', role: 'listbox', tabindex: 0,
      'aria-label': say`Folders and volumes`, 'data-testid': 'browse-list',
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.takeKey_(event)});
    /** @private */
    this.up_ = h('button', {type: 'button', class: 'quiet icon', 'aria-label': say`Folder above`,
      title: say`Folder above (Backspace)`, 'data-testid': 'browse-up',
      onclick: () => void this.goUp_()}, '↑');
    /** @private */
    this.where_ = h('output', {...DATA, class: 'grow where', 'data-testid': 'browse-path'});
    /** @private */
    this.find_ = h('input', {type: 'text', class: 'find', title: say`Part of a name`,
      autocomplete: 'off', spellcheck: 'false',
      'data-testid': 'browse-find', oninput: () => this.findSoon_(),
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.takeFindKey_(event)});
    /** @private */
    this.all_ = h('input', {type: 'checkbox', 'data-testid': 'browse-all',
      onchange: () => void this.load_(this.path_)});
    /** @private */
    this.told_ = h('p', {class: 'muted told', role: 'status', 'data-testid': 'browse-told'});
    /** @private What makes sense only if a folder is allowed. */
    this.parts_ = [h('div', {class: 'row'}, this.up_, this.where_,
      h('label', {class: 'row'}, say`Find`, this.find_)), this.list_,
      h('label', {class: 'row'}, this.all_, say`All files`)];
    const [bar, list, all] = this.parts_;
    this.root = h('div', {class: 'browser', role: 'group', 'data-testid': 'browse',
      'aria-label': say`Folders that this page may read`, hidden: true},
      bar, list, h('div', {class: 'row'}, this.told_, all));
  }

  /** Lists the folder that was shown last, or the first one. */
  async show() {
    if (this.find_.value !== '') {
      this.find_.value = '';
    }
    const question = this.asked_ + 1;
    const isListed = await this.load_(this.path_);
    if (this.asked_ !== question) {
      return;  // The user has chosen a folder meanwhile.
    }
    if (!isListed) {
      await this.load_('');  // The folder may have gone.
      if (this.asked_ !== question + 1) {
        return;
      }
    }
    const {listing_: listing} = this;
    if (listing?.path === '' && listing.entries.length === 1) {
      await this.load_(listing.entries[0].path);
    }
  }

  /**
   * Returns whether the list is that of the folder.
   * @private
   * @param {string} path
   */
  async load_(path) {
    const number = ++this.asked_;
    try {
      const {json} = await this.app_.connection.ask({ask: 'folder', path,
        find: this.find_.value.trim(), all: this.all_.checked});
      if (number !== this.asked_) {
        return false;
      }
      this.listing_ = json;
      this.path_ = json.path;
      this.draw_(json);
      return true;
    } catch (error) {
      if (number === this.asked_) {  // Else a newer question has replaced this one.
        setText(this.told_, /** @type {Error} */ (error).message);
      }
      return false;
    }
  }

  /**
   * @private
   * @param {Listing} listing
   */
  draw_(listing) {
    this.at_ = -1;
    this.list_.replaceChildren(...listing.entries.map((entry, at) => this.row_(entry, at)));
    this.list_.removeAttribute('aria-activedescendant');
    this.list_.scrollTop = 0;
    this.root.hidden = false;
    const allowsNone = listing.path === '' && listing.entries.length === 0;
    this.parts_.forEach(part => { part.hidden = allowsNone; });
    this.up_.disabled = listing.above === null;
    setText(this.where_, listing.path || say`Allowed folders`);
    setText(this.told_, toldOf(listing, this.find_.value.trim()));
  }

  /**
   * @private
   * @param {Entry} entry
   * @param {number} at
   */
  row_(entry, at) {
    return h('li', {role: 'option', id: `browse-${at}`, 'aria-selected': 'false',
      class: entry.is_folder ? 'folder' : 'file', 'data-testid': 'browse-entry',
      onclick: (/** @type {MouseEvent} */ event) => {
        if (event.detail > 1) {
          return;  // After the first click, this row may be another folder's.
        }
        this.choose_(at);
        if (entry.is_folder) {
          void this.enter_();
        }
      },
      ondblclick: () => entry.is_folder || this.acts_.open()},
      h('span', {...DATA, class: 'name', title: entry.name}, entry.name),
      h('span', {class: 'muted kind'},
        entry.is_folder ? say`folder` : KINDS.get(entry.kind) ?? entry.kind),
      h('span', {class: 'muted number'}, entry.bytes === null ? '' : sizeText(entry.bytes)),
      h('span', {class: 'muted number'},
        entry.modified_s === null ? '' : dateText(entry.modified_s)));
  }

  /**
   * @private
   * @param {number} at
   */
  choose_(at) {
    const {children} = this.list_;
    if (at < 0 || at >= children.length) {
      return;
    }
    children[this.at_]?.setAttribute('aria-selected', 'false');
    this.at_ = at;
    children[at].setAttribute('aria-selected', 'true');
    children[at].scrollIntoView({block: 'nearest'});
    this.list_.setAttribute('aria-activedescendant', children[at].id);
    this.acts_.pick(this.listing_?.entries[at].path ?? '');
  }

  /** Enters the chosen folder, or opens the chosen file. @private */
  async enter_() {
    const entry = this.listing_?.entries[this.at_];
    if (entry?.is_folder) {
      this.find_.value = '';
      if (await this.load_(entry.path)) {
        this.acts_.pick(entry.path);
      }
    } else if (entry) {
      this.acts_.open();
    }
  }

  /** @private */
  async goUp_() {
    const {listing_: listing} = this, from = this.path_;
    if (listing && listing.above !== null) {
      this.find_.value = '';
      if (await this.load_(listing.above)) {
        this.acts_.pick(this.path_);
        this.choose_(this.listing_?.entries.findIndex(({path}) => path === from) ?? -1);
      }
    }
  }

  /**
   * @private
   * @param {KeyboardEvent} event
   */
  takeKey_(event) {
    const last = (this.listing_?.entries.length ?? 0) - 1;
    /** @type {Record<string, number>} */
    const moves = {ArrowDown: this.at_ + 1, ArrowUp: this.at_ - 1, Home: 0, End: last,
      PageDown: this.at_ + PAGE_ROWS, PageUp: this.at_ - PAGE_ROWS};
    if (event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    if (event.key in moves) {
      this.choose_(Math.max(0, Math.min(last, moves[event.key])));
    } else if (event.key === 'Enter') {
      void this.enter_();
    } else if (event.key === 'ArrowRight' && this.listing_?.entries[this.at_]?.is_folder) {
      void this.enter_();
    } else if (event.key === 'Backspace' || event.key === 'ArrowLeft') {
      void this.goUp_();
    } else {
      return;
    }
    event.preventDefault();
  }

  /** @private */
  findSoon_() {
    clearTimeout(this.findTimer_);
    this.findTimer_ = setTimeout(() => void this.load_(this.path_), FIND_WAIT_MS);
  }

  /**
   * @private
   * @param {KeyboardEvent} event
   */
  takeFindKey_(event) {
    if (event.key === 'ArrowDown') {
      this.list_.focus();
      this.choose_(0);
    }
    if (event.key === 'ArrowDown' || event.key === 'Enter') {
      event.preventDefault();  // Enter would open what was picked before.
    }
  }
}

/**
 * Describes the listed entries and counts the omitted ones.
 * @param {Listing} listing
 * @param {string} find
 */
export function toldOf(listing, find) {
  const {entries, more, other_files: others, links_out: links, odd_names: odd} = listing;
  if (listing.path === '' && entries.length === 0) {
    return say`This server allows no folder. Start pxpl5 serve with --allow DIR, or open files from
      this computer.`;
  }
  const sentences = [find === '' ? allText(entries.length, more)
    : foundText(entries.length, more, find)];
  if (!listing.is_whole) {
    sentences.push(say`The folder is too long: a part of it was not searched.`);
  }
  if (others > 0) {
    sentences.push(plural(others, say`1 other file not shown.`,
      say`${grouped(others)} other files not shown.`));
  }
  if (links > 0) {
    sentences.push(plural(links, say`1 link to places that this page may not read.`,
      say`${grouped(links)} links to places that this page may not read.`));
  }
  if (odd > 0) {
    sentences.push(plural(odd, say`1 name that cannot be shown.`,
      say`${grouped(odd)} names that cannot be shown.`));
  }
  return sentences.join(' ');
}

/**
 * @param {number} count  Of listed entries.
 * @param {number} more   Entries that are not listed.
 */
function allText(count, more) {
  if (more > 0) {
    return say`The first ${grouped(count)} of ${grouped(count + more)} entries. Type a part of a
      name to find others.`;
  }
  return count === 0 ? say`Nothing to open here.`
    : plural(count, say`1 entry.`, say`${grouped(count)} entries.`);
}

/**
 * @param {number} count
 * @param {number} more
 * @param {string} find  What the names contain.
 */
function foundText(count, more, find) {
  if (more > 0) {
    return say`The first ${grouped(count)} of ${grouped(count + more)} entries with "${find}". Type
      a part of a name to find others.`;
  }
  return count === 0 ? say`Nothing to open here with "${find}".`
    : plural(count, say`1 entry with "${find}".`, say`${grouped(count)} entries with "${find}".`);
}
