/** Panel with a switch for each layer. */

import { byId, make } from "./dom.js";
import { LAYERS } from "./topics.js";

export class LayerPanel {
  /** @type {Set<string>} */ shown = new Set(Object.keys(LAYERS));

  /** @param {(layer: string, on: boolean) => void} switched */
  constructor(switched) {
    byId("layers").replaceChildren(...Object.entries(LAYERS).map(([layer, name]) => {
      const box = make("input", { type: "checkbox", role: "switch", checked: true, id: `layer-${layer}` });
      box.addEventListener("change", () => {
        if (box.checked) this.shown.add(layer);
        else this.shown.delete(layer);
        switched(layer, box.checked);
      });
      return make("label", { className: "switch" }, box, name);
    }));
  }
}
