/** Entry point: shows the login and, while logged in, the dashboard. */

import { Dashboard } from "./dashboard.js";
import { byId } from "./dom.js";
import { askToLogIn, onLogin } from "./login.js";
import { beginPanels } from "./panels.js";
import { Rest } from "./rest.js";
import { session } from "./session.js";

/** Begin anew, so that nothing of this login stays: no socket, no listener, no picture. @param {string} why */
function leave(why) {
  session.end(why);
  location.reload();
}

/** @param {string} token */
function enter(token) {
  session.begin(token);
  document.body.dataset.page = "app";
  const rest = new Rest(token);
  byId("logout").addEventListener("click", () => {
    const done = () => leave("");
    rest.logOut().then(done, done); // whether or not the cloud heard it
  });
  new Dashboard(rest, () => leave("Your login has expired: log in again.")).begin();
}

beginPanels();
onLogin(enter);
if (session.token) enter(session.token);
else askToLogIn(session.takeNote());
