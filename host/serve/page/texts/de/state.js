// German texts of the room "state".
export default {
  'layout': 'Anordnung',
  'window': 'Fenster',
  'slices': 'Schichten',
  'slabs': 'Schichtpakete',
  'oblique': 'schräg',
  'crosshair': 'Fadenkreuz',
  'measurements': 'Messungen',
  'The session\'s {0} was left out: {1}': 'Aus der Sitzung ausgelassen ({0}): {1}',
};
