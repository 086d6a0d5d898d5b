// A link of a given rate between a page and the server.
import { connect, createServer } from 'node:net';

/**
 * Listens on a port of its own and passes bytes on: to the server at once, to the page at a rate.
 * @param {string} url of the server, with its token
 * @param {number} bytes_per_s may be changed later
 */
export async function slowLink(url, bytes_per_s) {
  const target = new URL(url), port = Number(target.port);
  const link = { url: '', bytes_per_s, bytes: 0, close: () => {} };
  let freeAt = 0;  // The link is shared by all connections.
  const sockets = new Set();
  const listener = createServer(page => {
    const server = connect(port, '127.0.0.1');
    page.pipe(server);
    server.on('data', data => {
      server.pause();
      freeAt = Math.max(freeAt, performance.now()) + data.length / link.bytes_per_s * 1000;
      setTimeout(() => {
        link.bytes += data.length;
        page.write(data);
        server.resume();
      }, freeAt - performance.now());
    });
    server.on('end', () => setTimeout(() => page.end(), freeAt - performance.now()));
    for (const [one, other] of [[page, server], [server, page]]) {
      sockets.add(one);
      one.on('error', () => other.destroy()).on('close', () => sockets.delete(one));
    }
  });
  await new Promise(listening => listener.listen(0, '127.0.0.1', listening));
  target.port = String(listener.address().port);
  link.url = target.href;
  link.close = () => {
    sockets.forEach(each => each.destroy());
    listener.close();
  };
  return link;
}
