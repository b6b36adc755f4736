/** Alerts of the whole cloud, followed also while their page is closed. Those that somebody has acknowledged are apart until they happen again. */

import { isNew } from "../growing_map.js";
import { refused } from "../rest.js";
import { brokeOff, brokenParts, failedGoals, failedTasks, faultsOf, isAcknowledged, keyOf, lostRobots, robotOf, silentEndpoints } from "./alert_words.js";

const PERIOD = 10; // between two looks at failed tasks, ends of connections and acknowledgements [s]
const EARLIER = 86_400; // of which ends of connections are read at first [s]

export class AlertWatch {
  /** @type {import("./alert_words.js").Alert[]} open ones, the newest first */ alerts = [];
  /** @type {(import("./alert_words.js").Alert & {by: string, time: number})[]} those that somebody has seen to */ acknowledged = [];
  #context;
  #lookedAt = -Infinity;
  #looking = false;
  /** @type {object[]} */ #tasks = [];
  /** Since when robots are lost, by robot. @type {Map<string, number>} */ #lost = new Map();
  /** Robots that were connected when the cloud was asked last. @type {Set<string>} */ #connected = new Set();
  #endsReadTo = null;
  /** When alerts of unknown begin were seen first, and whether they were there at the first look. @type {Map<string, {since: number, earlier: boolean}>} */ #seen = new Map();
  #first = true;
  /** @type {Map<string, {by: string, time: number}>} by key */ #acknowledgements = new Map();

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
  }

  /** Take what the cloud said last, and ask it from time to time for what its lists do not have. */
  update() {
    const { cloud, failed } = this.#context;
    this.#notePresence();
    this.#show();
    const now = performance.now() / 1000;
    if (this.#looking || !cloud.me || now - this.#lookedAt < PERIOD) return;
    this.#lookedAt = now;
    this.#looking = true;
    const done = () => (this.#looking = false);
    this.#look().catch(failed).finally(done);
  }

  /** Acknowledge an alert, for all whom it concerns. @param {string} key */
  async acknowledge(key) {
    const { object, alert } = this.alerts.find((one) => one.key === key);
    const answer = await this.#context.rest.post("v1/acknowledgements", { object, alert });
    this.#acknowledgements.set(key, answer);
    this.#show();
  }

  async #look() {
    const { rest, cloud } = this.#context;
    const maps = [...new Set([...cloud.robots.map(({ map }) => map), cloud.map])].filter((id) => id !== null && !isNew(id));
    const gone = refused(404, () => []); // the map was removed meanwhile, or is not shown to the user
    const paths = maps.map((id) => `v1/maps/${encodeURIComponent(id)}/tasks?state=failed`);
    this.#tasks = (await Promise.all(paths.map((path) => rest.list(path).catch(gone)))).flat();
    if (cloud.isAdmin) await this.#readEnds();
    const acknowledged = await rest.list("v1/acknowledgements");
    this.#acknowledgements = new Map(acknowledged.map((one) => [keyOf(one), one]));
    this.#show();
  }

  /** Read which robots' connections broke off; only administrators may. */
  async #readEnds() {
    const { rest, cloud } = this.#context;
    const after = this.#endsReadTo ?? cloud.now - EARLIER;
    const { items } = await rest.get(`v1/audit?action=disconnect&after=${after}&limit=500`);
    for (const event of items.toReversed()) {
      const robot = robotOf(event, cloud.me.id);
      if (brokeOff(event)) this.#lost.set(robot, event.time);
      else if (event.details.role === "robot") this.#lost.delete(robot);
    }
    this.#endsReadTo = items[0]?.time ?? after;
  }

  /** Note which robots left; whether that was a farewell, only the audit log knows. */
  #notePresence() {
    const { cloud, journal } = this.#context;
    for (const { id, connected } of cloud.robots) {
      if (connected === null || connected === this.#connected.has(id)) continue;
      if (connected) this.#connected.add(id);
      else this.#connected.delete(id);
      if (cloud.isAdmin) continue;
      journal.add(cloud.now, id, connected ? "is connected" : "is not connected any more", !connected);
      if (connected) this.#lost.delete(id);
      else this.#lost.set(id, cloud.now);
    }
  }

  #show() {
    const { cloud, fleet } = this.#context;
    const found = [
      ...faultsOf(cloud.health), ...silentEndpoints(cloud.endpoints), ...lostRobots(cloud.robots, this.#lost),
      ...failedGoals(fleet.links), ...failedTasks(this.#tasks, cloud.now), ...brokenParts(cloud.building),
    ];
    const dated = found.map((alert) => ({ ...alert, ...this.#begin(alert, cloud.now) })).sort((a, b) => b.since - a.since || a.key.localeCompare(b.key));
    this.#seen = new Map(dated.map((alert) => [alert.key, alert]));
    this.#first = false;
    const isSeenTo = (alert) => isAcknowledged(alert, this.#acknowledgements.get(alert.key), cloud.now);
    this.alerts = dated.filter((alert) => !isSeenTo(alert));
    this.acknowledged = dated.filter(isSeenTo).map((alert) => ({ ...alert, ...this.#acknowledgements.get(alert.key) }));
  }

  /** When an alert began, as far as this page knows, and whether it began before the page looked. */
  #begin({ key, since }, now) {
    if (since !== null) return { since, earlier: false };
    const { since: seen, earlier } = this.#seen.get(key) ?? { since: now, earlier: this.#first };
    return { since: seen, earlier };
  }
}
