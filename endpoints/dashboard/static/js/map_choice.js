/** Choice of the map to show: a published one, or one that a robot makes. */

import { byId, make, show } from "./dom.js";
import { isNew, nameOf } from "./growing_map.js";

export class MapChoice {
  /** @type {string | null} */ current = null;
  #versions = new Map();
  #select = byId("map-choice");
  #chosen;

  /** @param {() => void} chosen */
  constructor(chosen) {
    this.#select.replaceChildren();
    this.#chosen = chosen;
    this.#select.onchange = () => this.choose(this.#select.value);
  }

  /** Choose another map. @param {string} id */
  choose(id) {
    if (id === this.current) return;
    this.current = id;
    this.#chosen();
  }

  get version() {
    return this.#versions.get(this.current);
  }

  /** @param {object[]} published @param {object[]} robots @param {object[]} containers */
  update(published, robots, containers) {
    const made = new Set(robots.map(({ map }) => map).filter(isNew));
    const maps = [...published, ...Array.from(made, (id) => ({ id, version: "" }))];
    this.#versions = new Map(maps.map(({ id, version }) => [id, version]));
    if (!this.#versions.has(this.current)) this.current = this.#best(maps, robots, containers);
    const count = (id) => robots.filter(({ map }) => map === id).length;
    const text = ({ id }) => (isNew(id) ? `${nameOf(id)}, being made (${count(id)})` : `${id}${count(id) ? ` (${count(id)})` : ""}`);
    show(this.#select, maps, ({ id }) => id, ({ id }) => make("option", { value: id }), (option, map) => {
      if (option.textContent !== text(map)) option.textContent = text(map);
    });
    this.#select.value = this.current ?? "";
    this.#select.disabled = !maps.length;
    this.#tellOfNone(maps);
  }

  /** The map where most goes on. */
  #best(maps, robots, containers) {
    const run = (id) => containers.filter(({ robot, map }) => robot && map.id === id).length;
    const stand = (id) => robots.filter(({ map }) => map === id).length;
    const order = (a, b) => run(b) - run(a) || stand(b) - stand(a) || a.localeCompare(b);
    return maps.map(({ id }) => id).sort(order)[0] ?? null;
  }

  #tellOfNone(maps) {
    const empty = byId("empty-stage");
    empty.hidden = maps.length > 0;
    if (empty.hidden || empty.children.length) return;
    empty.replaceChildren(
      make("h2", { textContent: "No map yet" }),
      make("p", { className: "muted", textContent: "Publish one, as map_server has them, and it is drawn here:" }),
      make("code", { textContent: "ppaas map publish docs/examples/office.yaml" }),
    );
  }
}
