/** Dialog that shows a secret once, to copy it. */

import { make, say } from "../dom.js";

const ROWS = 3;

export class OneTime {
  #title = make("h2");
  #text = make("textarea", { readOnly: true, rows: ROWS, spellcheck: false, "aria-label": "Secret" });
  #note = make("p", { className: "muted", role: "status" });
  #dialog = make("dialog", { className: "one-time" });

  constructor() {
    const copy = make("button", { className: "button primary", type: "button", textContent: "Copy", onclick: () => this.#copy() });
    const close = make("button", { className: "button", type: "button", textContent: "Close", onclick: () => this.#dialog.close() });
    this.#dialog.append(this.#title, make("p", { textContent: "It is shown only now, and the cloud does not keep it: copy it." }),
      this.#text, this.#note, make("div", { className: "actions" }, copy, close));
    this.#dialog.addEventListener("close", () => (this.#text.value = ""));
    document.body.append(this.#dialog);
  }

  /** @param {string} title @param {string} secret */
  show(title, secret) {
    say(this.#title, title);
    this.#dialog.setAttribute("aria-label", title);
    say(this.#note, "");
    this.#text.value = secret;
    this.#dialog.showModal();
  }

  async #copy() {
    this.#text.select();
    try {
      await navigator.clipboard.writeText(this.#text.value);
      say(this.#note, "Copied");
    } catch {
      say(this.#note, "This page may not copy, as it came without TLS: press Ctrl+C"); // what is to be copied is selected
    }
  }
}
