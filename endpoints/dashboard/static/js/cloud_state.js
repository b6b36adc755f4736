/** What the cloud said last, for all parts of the page. */

import { containersOf, mapsOf, withShared } from "./shared_robots.js";

const PERIOD = 10_000; // ms between two looks at buildings

export class CloudState {
  /** @type {object | null} */ health = null;
  /** @type {{id: string, role: string} | null} the user */ me = null;
  /** Radii of models [m]. @type {Map<string, number>} */ radii = new Map();
  /** @type {object[]} */ maps = [];
  /** @type {object[]} buildings that the user may read */ buildings = [];
  /** @type {object[]} the user's robots, and those that are shared with the user */ robots = [];
  /** @type {object[]} all that the user may see */ containers = [];
  /** @type {object[]} containers of these robots */ own = [];
  /** @type {object[] | null} null where the user may not see them */ machines = null;
  /** @type {object[] | null} null where the user may not see them */ endpoints = null;
  /** Id of the shown map. @type {string | null} */ map = null;
  /** Time of the last lists. */ at = new Date();
  /** When buildings were read [ms]. */ #looked = -Infinity;
  /** Clock of the cloud ahead of the page's [s]. */ #ahead = 0;

  get isAdmin() {
    return this.me?.role === "admin";
  }

  /** The clock of the cloud [s since the epoch]. */
  get now() {
    return Date.now() / 1000 + this.#ahead;
  }

  /** Ask how the cloud is. @param {import("./rest.js").Rest} rest */
  async look(rest) {
    this.health = await rest.get("v1/health");
    this.#ahead = this.health.time - Date.now() / 1000;
  }

  /** Read the lists. @param {import("./rest.js").Rest} rest */
  async read(rest) {
    if (!this.me) await this.#introduce(rest);
    const ofCloud = ["v1/machines", "v1/endpoints"].map((path) => (this.isAdmin ? rest.list(path) : null));
    const asked = ["v1/maps", "v1/robots", "v1/robots?shared=true", "v1/containers"].map((path) => rest.list(path));
    const [machines, endpoints, listed, mine, shared, containers] = await Promise.all([...ofCloud, ...asked]);
    const robots = withShared(mine, shared, this.me.id);
    const maps = await mapsOf(rest, listed, robots);
    Object.assign(this, { machines, endpoints, maps, robots, containers, own: containersOf(containers, robots, this.me.id) });
    await this.#readBuildings(rest);
    this.at = new Date();
  }

  /** Read buildings again at the next look: one was changed. */
  forgetBuildings() {
    this.#looked = -Infinity;
  }

  /** Buildings change rarely. */
  async #readBuildings(rest) {
    if (performance.now() - this.#looked < PERIOD) return;
    this.buildings = await rest.list("v1/buildings");
    this.#looked = performance.now();
  }

  async #introduce(rest) {
    const [me, models] = await Promise.all([rest.get("v1/users/me"), rest.list("v1/models")]);
    this.radii = new Map(models.map(({ name, robot_radius: radius }) => [name, radius]));
    this.me = me;
  }
}
