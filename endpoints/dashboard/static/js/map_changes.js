/** Changes of the shown map: polls versions that wait for a review, and sends what the user decides. */

import { MapPanel, partnersOf } from "./map_panel.js";

/**
 * What the user decides about versions that wait.
 * @param {import("./rest.js").Rest} rest @param {(order: Promise<object>, done: string) => Promise<void>} ask @param {() => string} pathOf path of the map
 */
export function decisions(rest, ask, pathOf) {
  const decide = ({ number }, decision, body, done) => ask(rest.post(`${pathOf()}/reviews/${number}/${decision}`, body), done);
  return {
    approve: (review, why) => decide(review, "approve", { why, force: review.outdated }, "Approved: robots go on with it"),
    refuse: (review, why) => decide(review, "refuse", { why }, "Refused"),
  };
}

export class MapChanges {
  #panel;
  #rest;
  #mark;
  #path = "";

  /**
   * @param {import("./rest.js").Rest} rest @param {{ask: (order: Promise<object>, done: string) => Promise<void>}} events
   * @param {(rectangles: {column: number, row: number, width: number, height: number}[]) => void} mark cells on the map
   */
  constructor(rest, events, mark) {
    this.#rest = rest;
    this.#mark = mark;
    this.#panel = new MapPanel({
      ...decisions(rest, events.ask, () => this.#path),
      merge: (other, into) => events.ask(rest.post(`${this.#path}/merge`, { with: other, into }), `${into} is merged of both maps`),
    });
  }

  /** Show what waits for a review. @param {string} path of the map @param {object[]} maps @param {string | null} current */
  async poll(path, maps, current) {
    this.#path = path;
    const published = maps.some(({ id }) => id === current);
    const reviews = published ? await this.#rest.list(`${path}/reviews`) : [];
    const waiting = reviews.filter(({ state }) => state === "waiting");
    this.#panel.update(waiting, partnersOf(maps, current));
    this.#mark(waiting.flatMap(({ rectangles }) => rectangles));
  }
}
