// Addresses of other servers on the same computer.

/**
 * The page of another port of the server's computer, also behind a portal, which has the port as
 * the last part of the path.
 * @param {number} port
 * @param {string} here  The address of this page.
 */
export function ofPort(port, here) {
  const url = new URL('.', here);
  if (/\/\d+\/$/.test(url.pathname)) {
    return new URL(`../${port}/`, url).href;
  }
  url.port = String(port);
  return url.href;
}
