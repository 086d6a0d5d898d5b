// Actions of the pointer and of the keys on a slice.
import {say} from '../texts/say.js';
import {takeTissue} from './slice_tools.js';

/** @typedef {import('./slice_view.js').SliceView} SliceView */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

const OLD_SLICE = say`This slice is still that of another volume. Try again when it has
  changed.`;

/**
 * @param {import('./slices.js').SlicesPanel} panel
 * @param {number} number  Index of the plane; the oblique slice follows the last.
 * @returns {import('./slice_input.js').Events}
 */
export function eventsOf(panel, number) {
  /** @param {(view: SliceView, volume: VolumeState) => void} act  With the slice of the volume. */
  const on = act => {
    document.dispatchEvent(new Event('pauseseries'));
    const view = panel.views()[number];
    if (panel.volume && view.isOld) {
      panel.message.fail(OLD_SLICE);
    } else if (panel.volume) {
      act(view, panel.volume);
    }
  };
  return {
    point: voxel => panel.point(number < panel.panes.length ? voxel
      : panel.oblique.hold(voxel)),
    measure: (phase, voxel) => on((view, volume) =>
      panel.measure.take(phase, voxel, view, volume)),
    end: (phase, end, voxel) => on((view, volume) =>
      panel.measure.drag(phase, end, voxel, view, volume)),
    tissue: value => on((_, volume) => takeTissue(panel.app, panel.message, volume, value)),
    hover: under => panel.hover(under, number),
    step: by => panel.step(number, by),
    window: (across, down) => panel.window.drag(across, down),
    zoom: (by, at) => panel.zoom(by, number, at),
  };
}
