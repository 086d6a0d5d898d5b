// Generated from page_schema.fbs, ringbus/schema/vocabulary.fbs and limits.def.
// Rewrite with: python3 host/serve/generate_page_schema.py --write

/** Limits of the machine. */
export const LIMITS = Object.freeze({
  region_px: 128,
  region_pixels: 16384,
  max_surfaces: 255,
  full_opacity: 16,
  few_samples: 4,
  many_samples: 16,
  max_lights: 4,
  max_specular_power: 128,
  max_nodes: 256,
  max_nodes_per_role: 64,
  min_volume_voxels: 2,
  max_volume_voxels: 4096,
  min_spacing_mm: 0.0001,
  max_spacing_mm: 1000,
  max_smooth_mm: 100,
  max_windows: 16,
  max_frames: 1000000,
  max_error_mm: 1000,
  max_frame_ms: 1e+09,
  least_window: 1e-06,
  most_window: 1e+12,
  max_slab: 4094,
  max_detail: 3,
  max_isovalues: 4096,
  max_picture_px: 8192,
  max_views: 2,
  max_clip_planes: 16,
  max_rim: 16,
  max_slice_planes: 3,
  plane_surface_id: 65535,
  max_scene_slab: 1048576,
  max_scene_mm: 1e+06,
  max_archive_structures: 65536,
  max_archive_primitives: 2000000,
  max_archive_notes: 16,
  max_note_length: 256,
  max_export_px: 16384,
  max_animation_pictures: 10000,
  max_delay_ms: 60000,
  max_marks: 100000,
  max_mark_points: 100000,
  max_mark_px: 100000,
  max_user_surfaces: 16,
  max_user_picture_px: 4096,
});

/** @typedef {'uint8' | 'int16' | 'uint16' | 'float32'} Scalar */

/** @typedef {'uint8' | 'int8' | 'uint16' | 'int16' | 'uint32' | 'int32' | 'uint64' |
 *   'int64' | 'float32' | 'float64'} Component */

/** @typedef {'automatic' | 'host' | 'gps'} ReadBy */

/** @typedef {'central' | 'smooth'} GradientKernel */

/** @typedef {'watertight' | 'lorensen1987' | 'asymptotic'} CaseRule */

/** @typedef {'all' | 'outside_gaps' | 'in_gaps'} SlabChoice */

/** @typedef {'note' | 'conversion' | 'assumption' | 'reflection' | 'gantry_tilt' |
 *   'missing_slices' | 'uneven_slices' | 'duplicate_slices' |
 *   'mixed_orientations' | 'thickness_differs' | 'other_series' | 'processed'
 *   | 'missing_volumes'} FindingKind */

/** @typedef {'line' | 'area' | 'text'} MarkKind */

/** @typedef {'LPS' | 'RAS'} PatientAxes */

/** @typedef {'prologue' | 'shut_door' | 'segment' | 'open_door' | 'depths' |
 *   'end_of_region'} PartKind */

/** @typedef {'off' | 'flight' | 'full'} Recording */

/** @typedef {'ipc' | 'tcp'} Transport */

/** @typedef {'replace' | 'degrade' | 'end'} RestartPolicy */

/** @typedef {'local' | 'slurm' | 'ssh' | 'mpirun' | 'command' | 'wait'} Engine */

/** @typedef {'pack' | 'spread'} Placement */

/** @typedef {'published' | 'recalled' | 'derived' | 'ours' | 'fitted'} Provenance */

/** @typedef {'best' | 'sse4' | 'avx2' | 'avx512'} VectorTarget */

export const PICTURE_KIND = Object.freeze({jpeg: 1, png: 2, vp8: 3});

export const FRAME_FLAG = Object.freeze({rests: 1, last: 2, full_color: 4, key: 8});

export const FRAME_HEADER_BYTES = 56;
export const FRAME_HEADER_MAGIC = 0x46523550;
/** Precedes the pictures and their depths in the message of a frame. A frame has `views` * `layers`
 * pictures of one size, encoded as one picture, from top to bottom: the layers of the first view,
 * then those of the second. Numbers are little-endian.
 * @param {DataView} view */
export function readFrameHeader(view) {
  return {
    number: view.getUint32(4, true),
    revision: view.getUint32(8, true),
    width: view.getUint16(12, true),
    height: view.getUint16(14, true),
    kind: view.getUint8(16),
    quality: view.getUint8(17),
    samples: view.getUint8(18),
    flags: view.getUint8(19),
    machine_ms: view.getFloat32(20, true),
    digest: view.getBigUint64(24, true),
    moved_mm: view.getFloat64(32, true),
    picture_bytes: view.getUint32(40, true),
    depth_bytes: view.getUint32(44, true),
    pose: view.getUint32(48, true),
    views: view.getUint8(52),
    layers: view.getUint8(53),
    opacity: view.getUint8(54),
    reserved: view.getUint8(55),
  };
}

export const ANSWER_HEADER_BYTES = 16;
export const ANSWER_HEADER_MAGIC = 0x4e413550;
/** Precedes the JSON and the bytes of an answer. Zeros fill up the JSON to a multiple of 8 bytes.
 * @param {DataView} view */
export function readAnswerHeader(view) {
  return {
    id: view.getUint32(4, true),
    json_bytes: view.getUint32(8, true),
    reserved: view.getUint32(12, true),
  };
}

/**
 * @typedef {object} FindingState
 * @property {string} kind
 * @property {string} text
 */

/**
 * @typedef {object} WindowState
 * @property {string} name
 * @property {number} window
 * @property {number} level
 */

/**
 * @typedef {object} VolumeState
 * @property {string} name
 * @property {string} source  file, folder or phantom:NAME
 * @property {string} identity  another one for other voxels, another place or another series
 * @property {string} series_identity  the same for all volumes of a time series
 * @property {number} frame  number in its time series, from 1
 * @property {number} frames  volumes of the time series; 1 if there is no series
 * @property {number} frame_ms  from one volume of the series to the next; 0 if unknown or uneven
 * @property {number} time_ms  time of this volume after the first volume; -1 if not known
 * @property {[number, number, number]} size  voxels
 * @property {[number, number, number]} spacing_mm
 * @property {string} modality  CT, MR, US, ...; empty if the file does not state it
 * @property {string} unit  of the values: HU, Bq/ml, ..., or empty
 * @property {string} gradient  a GradientKernel
 * @property {WindowState[]} windows  of gray values, as the file states them
 * @property {number} suv_per_value  standardized uptake value (g/ml) of 1; 0 if not known
 * @property {number} minimum
 * @property {number} maximum
 * @property {number} gaps  places where slices are missing
 * @property {FindingState[]} findings
 * @property {[number, number, number]} center_mm
 * @property {number} radius_mm
 * @property {number[]} voxel_to_patient  4 x 4, column-major
 * @property {number[]} slice_places  z of each slice in the grid; empty if slice z is at z
 */

/**
 * Matrices are column-major, as in WebGL.
 * @typedef {object} CameraState
 * @property {number} azimuth_deg
 * @property {number} elevation_deg
 * @property {number} roll_deg
 * @property {number} zoom
 * @property {[number, number]} pan_mm
 * @property {number[]} patient_to_eye  4 x 4
 * @property {number[]} patient_to_clip  4 x 4
 * @property {[number, number, number]} center_mm  of the sphere that the camera looks at
 * @property {number} radius_mm
 */

/**
 * @typedef {object} SurfaceState
 * @property {string} name
 * @property {number} isovalue
 * @property {string} color  #rrggbb
 * @property {boolean} visible
 * @property {number} opacity  0 .. 1
 * @property {number} rim  0 .. 1: light at its edges
 * @property {string} table  a CaseRule
 * @property {string} components  the filter as `components` takes it
 * @property {number} triangles
 * @property {number} vertices
 * @property {number} area_mm2
 * @property {number} volume_ml
 * @property {number} extraction_ms
 * @property {string} compared_with  the surface that this surface is compared with, or empty
 */

/**
 * A slice in the picture, across a voxel axis: x, y or z.
 * @typedef {object} PlaneState
 * @property {string} axis
 * @property {number} index
 */

/**
 * Angles are relative to the viewer.
 * @typedef {object} LightState
 * @property {number} azimuth_deg
 * @property {number} elevation_deg
 * @property {number} intensity
 */

/**
 * @typedef {object} MaterialState
 * @property {number} ambient
 * @property {number} specular
 * @property {number} power
 */

/**
 * Millimeters; kept where plane . (p, 1) >= 0.
 * @typedef {object} ClipState
 * @property {string} words
 * @property {[number, number, number, number]} plane
 */

/**
 * @typedef {object} MachineState
 * @property {string} topology
 * @property {number} gps
 * @property {number} renderers
 * @property {boolean} recording
 */

/**
 * Something outside of the program will end it.
 * @typedef {object} EndState
 * @property {string} at  "2026-11-24T05:00:00Z"; empty if unknown, but soon
 * @property {string} why  "job 12 reaches its time limit"
 * @property {string} open  the command that opens the saved session; empty if it is not saved
 */

/**
 * @typedef {object} State
 * @property {number} revision  counts changes of the picture's content
 * @property {string | null} busy  the work in progress
 * @property {VolumeState | null} volume
 * @property {string | null} archive  file of a scene of polygons, which replaces a volume
 * @property {CameraState} camera
 * @property {[number, number]} size  pixels of the picture; in stereo, of one eye's
 * @property {SurfaceState[]} surfaces
 * @property {LightState[]} lights
 * @property {MaterialState} material
 * @property {string} background  #rrggbb
 * @property {ClipState[]} clips
 * @property {PlaneState[]} planes
 * @property {number} planes_window  width of the gray window of all planes
 * @property {number} planes_level
 * @property {boolean} tint_gaps
 * @property {boolean} overlay
 * @property {string} detail  exact, auto, 1, 2 or 3, as `detail` takes it
 * @property {string} stereo  off, anaglyph, sbs, cross or rows, as `stereo` takes it
 * @property {number} stereo_separation_mm  between the eyes; 0: by the distance and the zoom
 * @property {number} stereo_convergence_mm  from the eyes to the screen; 0: the camera's
 * @property {string | null} undo  the line that `undo` reverts
 * @property {string | null} redo
 * @property {number} step  number of undo steps before now; `undo` lowers it by 1
 * @property {MachineState} machine
 * @property {EndState | null} end
 */
