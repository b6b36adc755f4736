/** Who is logged in: the token, kept for as long as this tab is open and nowhere else. */

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

  /** What was to be said; it is said once. @returns {string} */
  takeNote() {
    const note = sessionStorage.getItem(NOTE) ?? "";
    sessionStorage.removeItem(NOTE);
    return note;
  },
};
