/** Entry point: shows the login and, while logged in, the dashboard. */

import { Dashboard } from "./dashboard.js";
import { byId } from "./dom.js";
import { askToLogIn, onLogin, sentenceOf } from "./login.js";
import { beginPanels } from "./panels.js";
import { Rest } from "./rest.js";
import { session } from "./session.js";
import { endSignIn, offerSignIn, takeReturn } from "./sign_in.js";

/** Begin anew, so that nothing of this login stays: no socket, no listener, no picture. @param {string} why */
function leave(why) {
  session.end(why);
  location.reload();
}

/** End the login at the identity provider as well, which sends the browser back. @param {string} url */
function leaveTo(url) {
  session.end("");
  location.assign(url);
}

/** @param {string} token */
function enter(token) {
  session.begin(token);
  document.body.dataset.page = "app";
  const rest = new Rest(token);
  byId("logout").addEventListener("click", () => {
    const url = session.logoutUrl;
    const done = () => (url ? leaveTo(url) : leave(""));
    rest.logOut().then(done, done); // whether or not the cloud heard it
  });
  new Dashboard(rest, () => leave("Your login has expired: log in again.")).begin();
}

/** @param {{token: string, logout_url: string | null}} login */
function enterSignedIn(login) {
  session.keepLogout(login.logout_url);
  enter(login.token);
}

beginPanels();
onLogin((token) => {
  session.keepLogout(null);
  enter(token);
});
offerSignIn();
const back = takeReturn();
if (back) endSignIn(back).then(enterSignedIn, (error) => askToLogIn(sentenceOf(error)));
else if (session.token) enter(session.token);
else askToLogIn(session.takeNote());
