/** Forms that give one order to the cloud. */

import { make } from "./dom.js";

/** Attributes of an input for the name of a map. */
export const NAME_OF_MAP = { required: true, maxLength: 64, autocapitalize: "none", spellcheck: false };

/**
 * A form whose button is disabled until its order is done, which may take minutes.
 * @param {string} title @param {string} button its text @param {() => Promise<void>} order @param {...Node} fields
 */
export function orderForm(title, button, order, ...fields) {
  const send = make("button", { className: "button", textContent: button });
  const form = make("form", { className: "name-form", "aria-label": title }, ...fields, send);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    send.disabled = true;
    await order();
    send.disabled = false;
  });
  return form;
}
