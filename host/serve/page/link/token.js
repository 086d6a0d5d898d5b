// The token of the page, which is kept out of the address bar.

/** The pages behind one portal share an origin, and so the storage of a tab. */
const KEY = `pxpl5-token ${new URL('.', location.href).pathname}`;

/**
 * Takes the token from the page's address and removes it there: an address on the screen is read,
 * and copied, by others. The tab keeps the token until it is closed; the server's cookie lets the
 * page load again without it, and nothing else.
 * @returns {string} '' if there is none
 */
function take() {
  const url = new URL(location.href);
  const given = url.searchParams.get('token');
  try {
    if (given === null) {
      return sessionStorage.getItem(KEY) ?? '';
    }
    sessionStorage.setItem(KEY, given);
  } catch {
    return given ?? '';  // Without storage the address keeps the token.
  }
  url.searchParams.delete('token');
  history.replaceState(null, '', url);
  return given;
}

const token = take();

/** @returns {boolean} whether the server will accept this page */
export function hasToken() {
  return token !== '';
}

/**
 * A URL relative to the page, with the token of the page.
 * @param {string} path
 * @param {Record<string, string>} [query]
 */
export function address(path, query = {}) {
  const url = new URL(path, location.href);
  url.search = new URLSearchParams({...query, ...(token ? {token} : {})}).toString();
  return url;
}
