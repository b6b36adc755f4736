/** Login page. */

import { byId, say } from "./dom.js";
import { Refused, logIn } from "./rest.js";

/** The message of an error as a sentence. @param {Error} error */
export function sentenceOf(error) {
  return `${error.message[0].toUpperCase()}${error.message.slice(1)}.`.replace(/\.\.$/, ".");
}

/** @param {Error} error */
function reasonOf(error) {
  if (error instanceof Refused && error.status === 401) return "This user and password do not go together.";
  return sentenceOf(error);
}

/** Have the form log in. @param {(token: string) => void} entered */
export function onLogin(entered) {
  const [user, password] = [byId("login-user"), byId("login-password")];
  byId("login-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    byId("login-button").disabled = true;
    say(byId("login-error"), "");
    try {
      const token = await logIn(user.value, password.value);
      password.value = "";
      entered(token);
    } catch (error) {
      say(byId("login-error"), reasonOf(error));
      password.select();
    } finally {
      byId("login-button").disabled = false;
    }
  });
}

/** Show the form. @param {string} why it is asked for again, if it is */
export function askToLogIn(why = "") {
  document.body.dataset.page = "login";
  say(byId("login-error"), why);
  byId(byId("login-user").value ? "login-password" : "login-user").focus();
}
