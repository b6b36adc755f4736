/** Short messages that disappear by themselves. */

import { byId, make } from "./dom.js";

const SHOWN = 6000; // ms
const MOST = 4;

/** Say how an order of the user went. @param {Promise<unknown>} order @param {string} done */
export async function toastEnd(order, done) {
  try {
    await order;
    toast(done, "good");
  } catch (error) {
    toast(error.message, "bad");
  }
}

/** @param {string} text @param {"good" | "bad" | "plain"} kind */
export function toast(text, kind = "plain") {
  const toasts = byId("toasts");
  const again = [...toasts.children].find((element) => element.textContent === text);
  again?.remove();
  const element = make("div", { className: "toast", "data-kind": kind, textContent: text });
  toasts.append(element);
  while (toasts.children.length > MOST) toasts.firstChild.remove();
  setTimeout(() => element.remove(), SHOWN);
}
