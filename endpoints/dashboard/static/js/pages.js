/** Pages beside the map, one at a time. The address names the open one, so that the browser goes back and forth between them. */

import { byId, make, say, show } from "./dom.js";
import { Poller } from "./poller.js";
import { pagesInOrder } from "./registry.js";
import { Refused, Unreachable } from "./rest.js";

const MAP = { id: "", title: "Map" };

/** Show the map. */
export function closePage() {
  if (location.hash) location.hash = "";
}

/** Show a page. @param {string} id */
export function openPage(id) {
  location.hash = id;
}

export class Pages {
  /** @type {Map<string, import("./registry.js").Page>} */ #made = new Map();
  #open = "";
  #updated = false;
  #failed;
  #title = make("h2", { className: "page-title", tabIndex: -1 });
  #note = make("p", { className: "error", role: "alert" });
  #poller;

  /** @param {import("./registry.js").Context} context */
  constructor(context) {
    this.#failed = context.failed;
    for (const { id, create } of pagesInOrder()) this.#made.set(id, create(context));
    this.#poller = new Poller(async () => this.#made.get(this.#open)?.poll?.(), {
      well: () => say(this.#note, ""),
      failed: (error) => this.#refused(error),
    });
    addEventListener("hashchange", () => this.#go(true));
    this.#go(false);
  }

  /** Show what the cloud said last. */
  update() {
    if (!this.#updated) this.#poller.now(); // what a page that the address names asked before, no map was chosen for
    this.#updated = true;
    for (const page of this.#made.values()) page.update?.();
    this.#showLinks();
  }

  /** Look at once at what an order of the user has changed. */
  now() {
    this.#poller.now();
  }

  #refused(error) {
    if (error instanceof Refused && error.status !== 401) say(this.#note, error.message);
    else if (error instanceof Unreachable || error instanceof Refused) this.#failed(error);
    else throw error;
  }

  /** @param {boolean} asked whether the user asked for it now */
  #go(asked) {
    const id = location.hash.slice(1);
    this.#open = this.#made.has(id) ? id : "";
    const page = this.#made.get(this.#open);
    const entry = pagesInOrder().find((one) => one.id === this.#open);
    byId("app").dataset.view = this.#open || "map";
    byId("page").hidden = !page;
    say(this.#note, "");
    say(this.#title, entry?.title ?? "");
    byId("page").replaceChildren(...(page ? [this.#title, this.#note, page.element] : []));
    byId("page").scrollTop = 0;
    if (asked) (page ? this.#title : byId("map")).focus({ preventScroll: true });
    this.#showLinks();
    this.#poller.now();
  }

  #showLinks() {
    show(byId("pages"), [MAP, ...pagesInOrder()], ({ id }) => id, create, (link, { id }) => {
      if (id === this.#open) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
      const count = this.#made.get(id)?.count ?? 0;
      link.children[1].hidden = !count;
      say(link.children[1], String(count));
    });
  }
}

function create({ id, title }) {
  return make("a", { href: `#${id}` }, make("span", { textContent: title }), make("span", { className: "badge", hidden: true }));
}
