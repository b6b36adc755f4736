/** Panels that slide over the map on a phone, one at a time; on a desk all are shown. */

import { byId } from "./dom.js";

/** Show a panel, or none. @param {string} name empty for none */
export function showPanel(name) {
  byId("work").dataset.panel = name;
  for (const tab of document.querySelectorAll(".tab")) tab.setAttribute("aria-pressed", String(tab.dataset.panel === name));
}

/** Show the panel of a tab that is tapped, or hide it if it is shown. */
export function beginPanels() {
  for (const tab of document.querySelectorAll(".tab")) {
    tab.addEventListener("click", () => showPanel(byId("work").dataset.panel === tab.dataset.panel ? "" : tab.dataset.panel));
  }
}
