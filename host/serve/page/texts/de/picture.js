// German texts of the room "picture".
export default {
  'depths: {0} bytes, but a picture of {1} x {2} pixels with {3} seams has {4}. Load the page again; it may be older than the server.': 'Tiefen: {0} Bytes, aber ein Bild von {1} x {2} Pixeln mit {3} Nähten hat {4}. Laden Sie die Seite neu; sie kann älter sein als der Server.',
  'Browsers report the orientation of a phone only to pages of https:// or localhost. Give pxpl5 serve a certificate: --tls-cert and --tls-key.': 'Browser melden die Lage eines Telefons nur an Seiten von https:// oder localhost. Geben Sie pxpl5 serve ein Zertifikat: --tls-cert und --tls-key.',
  'The browser did not let this page read the orientation of the device. Allow "motion and orientation" for this page in the settings of the browser.': 'Der Browser ließ diese Seite die Lage des Geräts nicht lesen. Erlauben Sie dieser Seite in den Einstellungen des Browsers „Bewegung und Ausrichtung“.',
  'A picture could not be shown: {0}': 'Ein Bild konnte nicht gezeigt werden: {0}',
  'no picture within {0} ms': 'kein Bild innerhalb von {0} ms',
  'The browser cannot decode the video of moving pictures: {0}. They are sent as JPEG instead, which needs a faster link.': 'Der Browser kann das Video bewegter Bilder nicht dekodieren: {0}. Sie werden als JPEG gesendet; das braucht eine schnellere Verbindung.',
  'the browser cannot decode depths (deflate-raw)': 'der Browser kann keine Tiefen dekodieren (deflate-raw)',
  'the browser has taken WebGL back. It may return it; if not, load the page again': 'der Browser hat WebGL zurückgenommen. Vielleicht gibt er es wieder; sonst laden Sie die Seite neu',
  'depths cannot be read: {0}': 'Tiefen sind nicht lesbar: {0}',
  'the picture cannot be warped: {0}': 'das Bild kann nicht verformt werden: {0}',
  'the browser has no WebGL 2': 'der Browser hat kein WebGL 2',
  'the browser does not let the page read pictures, as it protects against fingerprinting': 'der Browser lässt die Seite keine Bilder lesen, weil er vor Wiedererkennung schützt',
  'the browser refuses the shaders: {0} {1}': 'der Browser lehnt die Shader ab: {0} {1}',
};
