/** Changes of the shown map: polls versions that wait for a review, and sends what the user decides. */

import { MapPanel, partnersOf } from "./map_panel.js";

export class MapChanges {
  #panel;
  #rest;
  #events;
  #mark;
  #path = "";

  /**
   * @param {import("./rest.js").Rest} rest @param {{ask: (order: Promise<object>, done: string) => Promise<void>}} events
   * @param {(rectangles: {column: number, row: number, width: number, height: number}[]) => void} mark cells on the map
   */
  constructor(rest, events, mark) {
    this.#rest = rest;
    this.#events = events;
    this.#mark = mark;
    this.#panel = new MapPanel({
      approve: (review, why) => this.#decide(review, "approve", { why, force: review.outdated }, "Approved: robots go on with it"),
      refuse: (review, why) => this.#decide(review, "refuse", { why }, "Refused"),
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

  #decide({ number }, decision, body, done) {
    return this.#events.ask(this.#rest.post(`${this.#path}/reviews/${number}/${decision}`, body), done);
  }
}
