// A link of a given rate and delay between a page and the server.
import { connect, createServer } from 'node:net';

/** Returns a function that passes data on, or null as the end, at its time and in order. */
function passTo(socket) {
  const waiting = [];
  return (data, at) => {
    waiting.push(data);
    setTimeout(() => {  // Timers of the same millisecond may come in any order.
      const next = waiting.shift();
      next === null ? socket.end() : socket.write(next);
    }, at - performance.now());
  };
}

/**
 * Listens on a port of its own and passes bytes on: to the server after the delay, to the page at a
 * rate and after the delay. A new connection takes a round trip more, as that of TCP does.
 * @param {string} url of the server, with its token
 * @param {number} bytes_per_s may be changed later
 * @param {number} delay_ms in each direction
 */
export async function slowLink(url, bytes_per_s, delay_ms = 0) {
  const target = new URL(url), port = Number(target.port);
  const link = { url: '', bytes_per_s, bytes: 0, close: () => {} };
  let freeAt = 0;  // The link is shared by all connections.
  const sockets = new Set();
  const listener = createServer(page => {
    const server = connect(port, '127.0.0.1');
    const openAt = performance.now() + 2 * delay_ms;
    const [toServer, toPage] = [passTo(server), passTo(page)];
    const arrival = () => Math.max(openAt, performance.now()) + delay_ms;
    page.on('data', data => toServer(data, arrival()));
    page.on('end', () => toServer(null, arrival()));
    server.on('data', data => {
      server.pause();
      freeAt = Math.max(freeAt, performance.now()) + data.length / link.bytes_per_s * 1000;
      setTimeout(() => server.resume(), freeAt - performance.now());
      link.bytes += data.length;
      toPage(data, freeAt + delay_ms);
    });
    server.on('end', () => toPage(null, freeAt + delay_ms));
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
