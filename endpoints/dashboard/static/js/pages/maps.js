/** Page with the maps: publish one; and, of the shown map, its versions, and those that wait for a review. */

import { make, say, show } from "../dom.js";
import { plural } from "../format.js";
import { isNew } from "../growing_map.js";
import { decisions } from "../map_changes.js";
import { createReview, fillReview } from "../map_panel.js";
import { closePage } from "../pages.js";
import { addPage } from "../registry.js";
import { beforeAndAfter } from "./before_after.js";
import { timeText } from "./event_words.js";
import { OF_VERSION, decisionOf, mayChange, readersOf } from "./map_words.js";
import { PublishForm } from "./publish_form.js";

const MOST = 50;

class MapsPage {
  #context;
  #decisions;
  #note = make("p", { className: "muted", role: "status" });
  #maps = make("ul", { className: "list cards", "aria-label": "Maps" });
  #title = make("h3");
  #waiting = make("ul", { className: "list", "aria-label": "Versions that wait for a review" });
  #closed = make("ul", { className: "muted", "aria-label": "Last reviews" });
  #versions = make("tbody");
  #shown = make("section", { "aria-label": "Shown map", className: "page-parts" });
  /** Versions whose pictures are being fetched, or are shown. @type {Set<string>} */ #pictured = new Set();
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#decisions = decisions(context.rest, context.ask, () => this.#path);
    const head = make("thead", {}, make("tr", {}, ...[...OF_VERSION.map(([title]) => title), ""].map((textContent) => make(textContent ? "th" : "td", { textContent, ...(textContent && { scope: "col" }) }))));
    const table = make("table", {}, make("caption", { className: "unseen", textContent: "Versions, the newest first" }), head, this.#versions);
    this.#shown.append(this.#title, this.#waiting, this.#closed, make("div", { className: "table", role: "region", "aria-label": "Versions", tabIndex: 0 }, table));
    const form = new PublishForm((files) => this.#publish(files));
    this.element.append(form.element, this.#maps, this.#shown, this.#note);
  }

  get #path() {
    return `v1/maps/${encodeURIComponent(this.#context.cloud.map)}`;
  }

  get #map() {
    const { cloud } = this.#context;
    return cloud.maps.find(({ id }) => id === cloud.map) ?? null;
  }

  update() {
    const { cloud } = this.#context;
    show(this.#maps, cloud.maps, ({ id }) => id, (map) => this.#createMap(map), (item, map) => {
      const robots = cloud.robots.filter((robot) => robot.map === map.id).length;
      say(item.children[1], `of ${map.owner}, ${readersOf(map)}, with ${plural(robots, "robot")} of yours`);
      say(item.children[2], map.description);
    });
  }

  async poll() {
    const { rest, cloud } = this.#context;
    const map = this.#map;
    this.#shown.hidden = map === null;
    say(this.#note, map ? "" : cloud.map === null || isNew(cloud.map) ? "Choose a published map above." : "");
    if (!map) return;
    const [versions, reviews] = await Promise.all([rest.get(`${this.#path}/versions?limit=${MOST}`), rest.list(`${this.#path}/reviews`)]);
    if (map.id !== this.#map?.id) return; // another one was chosen meanwhile
    say(this.#title, `Versions of ${map.id}`);
    const waiting = reviews.filter(({ state }) => state === "waiting");
    show(this.#waiting, waiting, ({ version }) => `${map.id} ${version}`, (review) => createReview(review, this.#decisions), fillReview);
    waiting.forEach((review, i) => this.#picture(map.id, review, this.#waiting.children[i]));
    show(this.#closed, reviews.filter(({ state }) => state !== "waiting"), ({ number }) => `${map.id} ${number}`, (review) => make("li", { textContent: decisionOf(review) }), () => {});
    show(this.#versions, versions.items, ({ number }) => `${map.id} ${number}`, (version) => this.#createVersion(version, map), (row, version) => this.#fillVersion(row, version));
  }

  /** Show before and after beside a version that waits, once. */
  async #picture(id, { version, parts, rectangles }, item) {
    const key = `${id} ${version}`;
    if (this.#pictured.has(key) || !parts.includes("image")) return;
    this.#pictured.add(key);
    try {
      const [before, after] = await Promise.all([this.#context.rest.grid(id), this.#context.rest.grid(id, version)]);
      item.insertBefore(beforeAndAfter(before, after, rectangles), item.children[2]);
    } catch (error) {
      this.#pictured.delete(key); // the next look tries again
      this.#context.failed(error);
    }
  }

  #createMap({ id, owner }) {
    const actions = make("div", { className: "actions" }, button("Show", `Show ${id} on the map`, () => this.#show(id)), button("Versions", `Versions of ${id}`, () => this.#context.chooseMap(id)));
    if (mayChange({ owner }, this.#context.cloud.me)) actions.append(button("Remove", `Remove ${id}`, () => this.#remove(id), true));
    return make("li", { className: "review" }, make("span", { className: "name", textContent: id }), make("span", { className: "muted" }), make("span"), actions);
  }

  #show(id) {
    this.#context.chooseMap(id);
    closePage();
  }

  #createVersion({ version }, map) {
    const back = button("Roll back", "", () => this.#rollBack(version));
    back.hidden = !mayChange(map, this.#context.cloud.me);
    return make("tr", { "data-outcome": "ok" }, ...OF_VERSION.map(() => make("td")), make("td", {}, back, make("span", { className: "muted" })));
  }

  #fillVersion(row, version) {
    const when = timeText(version.created, this.#context.cloud.now);
    OF_VERSION.forEach(([, text], i) => say(row.children[i], text(version, when)));
    const [back, current] = row.lastChild.children;
    back.setAttribute("aria-label", `Roll back to the version of ${when}`);
    back.disabled = version.present;
    say(current, version.present ? "current" : "");
  }

  #rollBack(version) {
    if (!confirm("Make this version the current one again? Robots that drive go on with it.")) return;
    this.#context.ask(this.#context.rest.post(`${this.#path}/roll_back`, { version }), "The version is the current one again");
  }

  #remove(id) {
    if (!confirm(`Remove ${id}, with its versions, stored paths, tasks and counts of people?`)) return;
    this.#context.ask(this.#context.rest.delete(`v1/maps/${encodeURIComponent(id)}`), `${id} is removed`);
  }

  /** Publish a map; the form shows why it is refused. */
  async #publish(files) {
    await this.#context.rest.upload("v1/maps", files);
    await this.#context.ask(Promise.resolve(), files.has("review") ? "The version waits for a review" : `${files.get("id")} is published`);
  }
}

function button(textContent, label, onclick, stop = false) {
  return make("button", { className: stop ? "button stop" : "button", type: "button", textContent, ...(label && { "aria-label": label }), onclick });
}

addPage({ id: "maps", title: "Maps", order: 2.5, create: (context) => new MapsPage(context) });
