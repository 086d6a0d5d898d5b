// German texts of the room "link".
export default {
  'The server closed the connection: too many messages, or not allowed.': 'Der Server hat die Verbindung geschlossen: zu viele Nachrichten oder nicht erlaubt.',
  'The server closed the connection: a message was too long.': 'Der Server hat die Verbindung geschlossen: Eine Nachricht war zu lang.',
  'The server closed the connection: it is overloaded.': 'Der Server hat die Verbindung geschlossen: Er ist überlastet.',
  'The connection was lost before the server replied.': 'Die Verbindung ging verloren, bevor der Server geantwortet hat.',
  'Not connected.': 'Nicht verbunden.',
  'Not connected: nothing was changed.': 'Nicht verbunden: Nichts wurde geändert.',
  'Load the page again; it may be older than the server.': 'Laden Sie die Seite neu; sie kann älter sein als der Server.',
  'Frame: {0} bytes, its header has {1}. {2}': 'Bild: {0} Byte, sein Kopf hat {1}. {2}',
  'Frame: {0} bytes, its picture and depths end at {1}. {2}': 'Bild: {0} Byte, sein Bild und seine Tiefen enden bei {1}. {2}',
  'Frame: kind {0} is none of JPEG (1), PNG (2) and VP8 (3). {1}': 'Bild: Die Art {0} ist weder JPEG (1) noch PNG (2) oder VP8 (3). {1}',
  'Frame: the depths of picture {0} end at byte {1}, but the frame has {2} bytes. {3}': 'Bild: Die Tiefen von Bild {0} enden bei Byte {1}, aber das Bild hat {2} Byte. {3}',
  'Answer: {0} bytes, its header has {1}. {2}': 'Antwort: {0} Byte, ihr Kopf hat {1}. {2}',
  'Answer: {0} bytes, its JSON ends at {1}. {2}': 'Antwort: {0} Byte, ihr JSON endet bei {1}. {2}',
  'Message: {0} bytes, neither a frame nor an answer. {1}': 'Nachricht: {0} Byte, weder Bild noch Antwort. {1}',
  'The server closed the connection: {0}': 'Der Server hat die Verbindung geschlossen: {0}',
};
