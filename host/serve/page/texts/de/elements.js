// German texts of the room "elements".
export default {
  'this browser has no 2D canvas': 'dieser Browser hat keine 2D-Zeichenfläche',
  'The browser cannot write a picture of {0} x {1} pixels. Choose a smaller size.': 'Der Browser kann kein Bild von {0} x {1} Pixeln schreiben. Wählen Sie eine kleinere Größe.',
  'Close this message': 'Diese Meldung schließen',
  'Cancel': 'Abbrechen',
};
