// The tools for slices, and what the tool Tissue does.
import {isoCommand, roundIso} from '../link/lines.js';
import {say} from '../texts/say.js';

/** @type {{name: import('./slice_input.js').Tool, title: string, help: string}[]} */
export const TOOLS = [
  {name: 'point', title: say`Point`, help: say`Move the crosshair, here and in the picture`},
  {name: 'move', title: say`Move`, help: say`Drag a zoomed slice (with any tool: middle button).
    Ctrl and the wheel zoom`},
  {name: 'measure', title: say`Measure`, help: say`Distances, angles and paths; areas and values
    of regions`},
  {name: 'window', title: say`Window`, help: say`Drag across for contrast, down for brightness
    (with any tool: right button or Shift)`},
  {name: 'tissue', title: say`Tissue`, help: say`Set the isovalue to the value under the pointer`},
];

/**
 * Gives a value to the mode that waits for one, or to the chosen surface as its isovalue.
 * @param {import('../panel/app.js').App} app
 * @param {{fail: (text: string) => void}} message
 * @param {import('../link/vocabulary.js').VolumeState} volume
 * @param {number} value
 */
export function takeTissue({connection, modes, selection}, message, volume, value) {
  if (modes.current?.value) {
    modes.current.value(value);
  } else if (selection.name === '') {
    message.fail(say`There is no surface to adjust. Add a surface first.`);
  } else {
    connection.mark();
    void connection.set(isoCommand(selection.name, roundIso(value, volume)));
  }
}
