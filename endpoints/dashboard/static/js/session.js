/** Token of the logged-in user, stored only while this tab is open. */

const KEY = "ppaas-token";
const NOTE = "ppaas-note";

export const session = {
  /** @returns {string | null} */
  get token() {
    return sessionStorage.getItem(KEY);
  },

  /** @param {string} token */
  begin(token) {
    sessionStorage.setItem(KEY, token);
  },

  /** @param {string} note what to say to whoever logs in next */
  end(note) {
    sessionStorage.removeItem(KEY);
    sessionStorage.setItem(NOTE, note);
  },

  /** Return the pending message once. @returns {string} */
  takeNote() {
    const note = sessionStorage.getItem(NOTE) ?? "";
    sessionStorage.removeItem(NOTE);
    return note;
  },
};
