// What the server says, as types. host/serve/README.md defines it.

/** @typedef {[number, number, number]} Triple   Patient coordinates in millimetres, LPS. */

/**
 * @typedef {object} VolumeState
 * @property {string} name
 * @property {string} source
 * @property {Triple} size              Voxels.
 * @property {Triple} spacing_mm
 * @property {string} modality          'CT', 'MR', 'US', ... or ''.
 * @property {string} unit              Of the values, 'HU' or ''.
 * @property {number} minimum
 * @property {number} maximum
 * @property {number} gaps              Places where slices are missing.
 * @property {{kind: string, text: string}[]} findings
 * @property {Triple} centre_mm
 * @property {number} radius_mm
 * @property {number[]} voxel_to_patient   4 x 4, column-major.
 * @property {number[]} slice_places
 */

/**
 * @typedef {object} CameraState
 * @property {number} azimuth_deg
 * @property {number} elevation_deg
 * @property {number} roll_deg
 * @property {number} zoom
 * @property {[number, number]} pan_mm
 * @property {number[]} patient_to_eye    4 x 4, column-major.
 * @property {number[]} patient_to_clip   4 x 4, column-major.
 */

/**
 * @typedef {object} SurfaceState
 * @property {string} name
 * @property {number} isovalue
 * @property {string} color             '#rrggbb'.
 * @property {boolean} visible
 * @property {number} opacity           0..1.
 * @property {string} table             'watertight', 'lorensen1987' or 'asymptotic'.
 * @property {string} components        What is drawn of it, in words; '' if all.
 * @property {number} triangles
 * @property {number} vertices
 * @property {number} area_mm2
 * @property {number} volume_ml
 * @property {number} extraction_ms
 * @property {string} compared_with     The surface that this is a comparison of, or ''.
 */

/** @typedef {{azimuth_deg: number, elevation_deg: number, intensity: number}} LightState */
/** @typedef {{ambient: number, specular: number, power: number}} MaterialState */
/** @typedef {{words: string, plane: [number, number, number, number]}} ClipState */

/**
 * @typedef {object} State
 * @property {number} revision
 * @property {string | null} busy
 * @property {VolumeState | null} volume
 * @property {string | null} [archive]   A PPHIGS archive that is open in a volume's place.
 * @property {CameraState} camera
 * @property {[number, number]} size    Of the picture, pixels.
 * @property {SurfaceState[]} surfaces
 * @property {LightState[]} lights      As seen by the viewer.
 * @property {MaterialState} material
 * @property {string} background        '#rrggbb'.
 * @property {ClipState[]} clips        In mm; kept where plane . (p, 1) >= 0.
 * @property {boolean} tint_gaps
 * @property {boolean} overlay
 * @property {string | null} undo       The line that would be undone.
 * @property {string | null} redo
 * @property {{topology: string, gps: number, renderers: number, recording: boolean}} machine
 */

/**
 * @typedef {object} Reply
 * @property {boolean} ok
 * @property {string} [text]
 * @property {any} [result]             The command's fields.
 * @property {number} [ms]
 * @property {number} [revision]        Of the state that the command led to.
 * @property {string} [error]           A sentence.
 * @property {boolean} [superseded]     A newer setting took its place.
 */

/**
 * A command of the server: see `descriptor_fields` in host/base/command_descriptor.hpp.
 * @typedef {object} CommandDescriptor
 * @property {string} name
 * @property {'question' | 'setting' | 'action' | 'memory'} kind
 * @property {number} subject_words     Number of words that name the subject of a setting.
 */

/**
 * @typedef {{version: string, role: 'driver' | 'watcher', viewer: number, topology: string,
 *   commands: CommandDescriptor[]}} Hello
 */
/** @typedef {{what: string, done: number, total: number}} Progress */
/** @typedef {{level: 'info' | 'error', text: string}} Note */
/** @typedef {{json: any, bytes: ArrayBuffer}} Answer */

/**
 * @typedef {object} FrameHeader
 * @property {number} number
 * @property {number} revision
 * @property {number} width
 * @property {number} height
 * @property {'jpeg' | 'png'} kind
 * @property {number} quality           Of the JPEG, 1..100.
 * @property {number} samples           A pixel.
 * @property {boolean} rests
 * @property {boolean} last             The last refinement.
 * @property {number} machine_ms
 * @property {string} digest            16 hexadecimal digits, '' while moving.
 */

export {};
