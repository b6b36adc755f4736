/** Token of the logged-in user, stored only while this tab is open. */

const KEY = "ppaas-token";
const NOTE = "ppaas-note";
const LOGOUT = "ppaas-logout";

export const session = {
  /** @returns {string | null} */
  get token() {
    return sessionStorage.getItem(KEY);
  },

  /** Where the login at the identity provider ends, if it was one. @returns {string | null} */
  get logoutUrl() {
    return sessionStorage.getItem(LOGOUT);
  },

  /** @param {string} token */
  begin(token) {
    sessionStorage.setItem(KEY, token);
  },

  /** @param {string | null} url where the login at the identity provider ends */
  keepLogout(url) {
    if (url) sessionStorage.setItem(LOGOUT, url);
    else sessionStorage.removeItem(LOGOUT);
  },

  /** @param {string} note what to say to whoever logs in next */
  end(note) {
    sessionStorage.removeItem(KEY);
    sessionStorage.removeItem(LOGOUT);
    sessionStorage.setItem(NOTE, note);
  },

  /** Return the pending message once. @returns {string} */
  takeNote() {
    const note = sessionStorage.getItem(NOTE) ?? "";
    sessionStorage.removeItem(NOTE);
    return note;
  },
};
