// German texts of index.html and main.js.
export default {
  'Picture': 'Bild',
  'Picture of the surfaces. Arrow keys rotate the view. Plus and minus zoom.': 'Bild der Oberflächen. Pfeiltasten drehen die Ansicht. Plus und Minus ändern die Größe.',
  'Time series': 'Zeitreihe',
  'Connection lost': 'Verbindung unterbrochen',
  'Page of the class': 'Seite der Klasse',
  'Surfaces, clip planes and lights': 'Oberflächen, Schnittebenen und Lichter',
  'Slices, inspector, machine and volume': 'Schichten, Inspektor, Maschine und Volumen',
  'Panels': 'Felder',
  'Surfaces and measurements': 'Oberflächen und Messungen',
};
