// Whether this page can use a headset, and if not, why.
import {say} from '../texts/say.js';

/**
 * What the user can do about an address that is not secure. Browsers offer WebXR on https: and on
 * localhost only.
 * @param {string} port  Of the page.
 */
export function insecureReason(port) {
  return say`A headset needs a secure address, and this address is not secure. Start pxpl5 serve
    with --tls-cert and --tls-key. Or connect the headset by a cable to the computer of pxpl5 serve,
    run “adb reverse tcp:${port} tcp:${port}” there, and open http://localhost:${port} with the
    printed token in the browser of the headset.`;
}

/**
 * @returns {Promise<string>} why this browser shows nothing in a headset; '' if it does
 */
export async function reasonAgainst() {
  if (!window.isSecureContext) {
    return insecureReason(location.port || '80');
  }
  if (!navigator.xr) {
    return say`This browser has no WebXR. Chrome, Edge and the browsers of headsets have it.`;
  }
  try {
    return await navigator.xr.isSessionSupported('immersive-vr') ? ''
      : say`The browser has found no headset. Connect one, or open this page in the browser of the
        headset.`;
  } catch (error) {
    return say`The browser does not let this page use a headset: ${
      error instanceof Error ? error.message : String(error)}`;
  }
}
