// A printed page has picture and slices, and these lists: surfaces with values, measurements.
import {byId, h} from '../elements/dom.js';
import {percent, short} from '../elements/numbers.js';
import {KIND_TITLES, measureText} from '../panel/measures.js';
import {partText, slabNote, valuesText} from '../panel/measure_words.js';
import {say} from '../texts/say.js';

/** @param {import('../panel/app.js').App} app */
export function createPrint(app) {
  const surfaces = h('ul', {'data-testid': 'print-surfaces'});
  const measures = h('ol', {'data-testid': 'print-measures'});
  const title = h('h2', {}, say`Measurements`);
  byId('print').append(h('h2', {}, say`Surfaces`), surfaces, title, measures);
  const unit = () => app.store.state?.volume?.unit ?? '';
  const list = (/** @type {import('../link/vocabulary.js').State} */ state) => {
    surfaces.replaceChildren(...state.surfaces.filter(({visible}) => visible).map(each => {
      const swatch = h('i', {class: 'swatch'});
      swatch.style.backgroundColor = each.color;
      return h('li', {class: 'row'}, swatch, h('b', {}, each.name),
        say`isovalue ${`${short(each.isovalue, 3)} ${unit()}`.trim()}`,
        each.opacity < 1 && `, ${say`opacity ${percent(each.opacity)}`}`,
        each.rim > 0 && `, ${say`edge light ${percent(each.rim)}`}`);
    }));
  };
  app.store.follow(['surfaces', 'volume'], list);
  addEventListener('beforeprint', () => {
    if (app.store.state) {
      list(app.store.state);
    }
  });
  app.measures.watch(() => {
    title.hidden = app.measures.list.length === 0;
    measures.replaceChildren(...app.measures.list.map(each => h('li', {class: 'row'},
      h('b', {}, each.name), `${KIND_TITLES[each.kind]}: ${measureText(each)}`,
      each.part && `(${partText(each.part, unit())})`,
      each.values && `(${valuesText(each.values, unit())}${slabNote(each.slice)})`)));
  });
}
