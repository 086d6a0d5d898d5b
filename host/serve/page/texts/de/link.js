// German texts of the room "link".
export default {
  'The server closed the connection: too many messages, or not allowed.': 'Der Server hat die Verbindung geschlossen: zu viele Nachrichten oder nicht erlaubt.',
  'The server closed the connection: a message was too long.': 'Der Server hat die Verbindung geschlossen: Eine Nachricht war zu lang.',
  'The server closed the connection: it is overloaded.': 'Der Server hat die Verbindung geschlossen: Er ist überlastet.',
  'The connection was lost before the server replied.': 'Die Verbindung ging verloren, bevor der Server geantwortet hat.',
  'Not connected.': 'Nicht verbunden.',
  'Not connected: nothing was changed.': 'Nicht verbunden: Nichts wurde geändert.',
  'The server closed the connection: {0}': 'Der Server hat die Verbindung geschlossen: {0}',
};
