/** Login with the identity provider of the cloud, if it has one: it takes the browser there, and receives it back. */

import { byId, say } from "./dom.js";
import { sentenceOf } from "./login.js";
import { beginLogin, endLogin, providerName } from "./rest.js";

const KEY = "ppaas-sign-in";

let refused = false; // who was refused may have another account there

/** What the provider has put into the address, once: a reload must not repeat it. @returns {URLSearchParams | null} */
export function takeReturn() {
  const found = new URLSearchParams(location.search);
  if (!found.has("state") || !(found.has("code") || found.has("error"))) return null;
  history.replaceState(null, "", location.pathname);
  return found;
}

/**
 * End the login of a browser that the provider has sent back.
 * @param {URLSearchParams} found what was in the address
 * @returns {Promise<{token: string, logout_url: string | null}>}
 */
export async function endSignIn(found) {
  refused = true;
  const begun = JSON.parse(sessionStorage.getItem(KEY) ?? "null");
  sessionStorage.removeItem(KEY);
  if (!begun || begun.state !== found.get("state")) {
    throw new Error("this login was not begun in this tab: log in again");
  }
  if (found.has("error")) {
    throw new Error(`the identity provider refused: ${found.get("error_description") ?? found.get("error")}`);
  }
  const { nonce, verifier } = begun;
  const login = await endLogin({ code: found.get("code"), nonce, verifier, ...(found.has("iss") && { iss: found.get("iss") }) });
  refused = false;
  return login;
}

/** Go to the provider. */
async function leave() {
  const { url, ...kept } = await beginLogin(refused);
  sessionStorage.setItem(KEY, JSON.stringify(kept));
  location.assign(url);
}

/** Show the button, if the cloud has a provider. */
export async function offerSignIn() {
  const button = byId("provider-button");
  const name = await providerName().catch(() => null); // passwords work without
  if (name === null) return;
  say(button, `Sign in with ${name}`);
  button.hidden = false;
  addEventListener("pageshow", () => (button.disabled = false)); // also after a step back from the provider
  button.addEventListener("click", () => {
    button.disabled = true;
    say(byId("login-error"), "");
    leave().catch((error) => {
      button.disabled = false;
      say(byId("login-error"), sentenceOf(error));
    });
  });
}
