/** People on the shown map: polls them while robots track some, and sends what the user wants. */

import { PeopleLayer } from "./people_layer.js";
import { PeoplePanel } from "./people_panel.js";
import { PeopleState } from "./people_state.js";
import { Refused } from "./rest.js";
import { readTheme } from "./theme.js";

const PERIOD = 500; // ms between two looks while people are tracked

export class People {
  state = new PeopleState();
  layer = new PeopleLayer(this.state, readTheme());
  #panel;
  #rest;
  #events;
  /** Path of the people of the shown map, or null. @type {string | null} */ #path = null;
  #timer = 0;

  /**
   * @param {import("./rest.js").Rest} rest
   * @param {{changed: () => void, failed: (error: Error) => void, ask: (order: Promise<object>, done: string) => Promise<void>}} events
   */
  constructor(rest, events) {
    this.#rest = rest;
    this.#events = events;
    this.#panel = new PeoplePanel({
      follow: (id) => this.#follow(id),
      pick: (id) => this.pick(id === this.state.picked ? null : id),
      change: (settings) => this.#change(settings),
      colourOf: (id) => this.layer.colourOf(id),
    });
  }

  /** Read the people and the settings of a map. @param {string | null} path of the map, or null for one that is being made */
  async poll(path) {
    const people = path && `${path}/people`;
    if (people !== this.#path) this.state.clear();
    this.#path = people;
    if (people) {
      const [answer, settings] = await Promise.all([this.#rest.get(people), this.#rest.get(`${people}/settings`)]);
      if (people !== this.#path) return; // another map was chosen meanwhile
      this.state.settings = settings;
      this.state.take(answer);
    }
    this.#show();
    if (this.state.active && !this.#timer) this.#timer = setTimeout(() => this.#again(), PERIOD);
  }

  /** Pick the person of a list entry or of a place on the map. @param {number | null} id */
  pick(id) {
    this.state.picked = id;
    this.#show();
  }

  /** Pick the person at a point of the map, or nobody. @param {{x: number, y: number}} point @param {number} reach [m] */
  pickAt(point, reach) {
    this.pick(this.state.at(point, reach)?.id ?? null);
  }

  /** Look again soon: the other lists of the page change less often. */
  async #again() {
    const path = this.#path;
    try {
      const answer = path && document.visibilityState === "visible" ? await this.#rest.get(path) : null;
      if (answer && path === this.#path) this.state.take(answer);
      this.#show();
    } catch (error) {
      if (!(error instanceof Refused) || error.status === 401) this.#events.failed(error);
    }
    this.#timer = this.state.active && path === this.#path ? setTimeout(() => this.#again(), PERIOD) : 0;
  }

  #show() {
    this.#panel.update(this.state);
    this.#events.changed();
  }

  #follow(id) {
    const people = this.state.targetsWith(id);
    const done = people.length ? `To be followed: ${people.join(", ")}` : "Nobody is to be followed";
    return this.#send(this.#rest.post(`${this.#path}/follow`, { people }), done);
  }

  #change(settings) {
    return this.#send(this.#rest.patch(`${this.#path}/settings`, settings), "Changed");
  }

  async #send(order, done) {
    await this.#events.ask(order.then((settings) => (this.state.settings = settings)), done);
    this.#show();
  }
}
