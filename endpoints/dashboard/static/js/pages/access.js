/** Page with the user's tokens and, for administrators, the users. */

import { make } from "../dom.js";
import { addPage } from "../registry.js";
import { TokensPanel } from "./tokens_panel.js";
import { UsersPanel } from "./users_panel.js";

class AccessPage {
  #panels;
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#panels = [new TokensPanel(context), new UsersPanel(context)];
    this.element.append(...this.#panels.map(({ element }) => element));
  }

  async poll() {
    await Promise.all(this.#panels.map((panel) => panel.poll()));
  }
}

addPage({ id: "access", title: "Access", order: 4, create: (context) => new AccessPage(context) });
