/** Alerts of the whole cloud, followed also while their page is closed. An acknowledged one is hidden in this tab until it happens again. */

import { isNew } from "../growing_map.js";
import { refused } from "../rest.js";
import { brokeOff, failedGoals, failedTasks, faultsOf, lostRobots, robotOf, silentEndpoints } from "./alert_words.js";

const PERIOD = 10; // between two looks at failed tasks and ends of connections [s]
const EARLIER = 86_400; // of which ends of connections are read at first [s]
const KEY = "ppaas-acknowledged";

export class AlertWatch {
  /** @type {import("./alert_words.js").Alert[]} the newest first */ alerts = [];
  #context;
  #lookedAt = -Infinity;
  #looking = false;
  /** @type {object[]} */ #tasks = [];
  /** Since when robots are lost, by robot. @type {Map<string, number>} */ #lost = new Map();
  /** Robots that were connected when the cloud was asked last. @type {Set<string>} */ #connected = new Set();
  #endsReadTo = null;
  /** When alerts of unknown begin were seen first. @type {Map<string, number>} */ #seen = new Map();
  /** @type {Record<string, number>} begin of acknowledged alerts, by key */ #acknowledged = JSON.parse(sessionStorage.getItem(KEY) ?? "{}");

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

  /** Hide an alert. @param {string} key */
  acknowledge(key) {
    const alert = this.alerts.find((one) => one.key === key);
    if (alert) this.#acknowledged = { ...this.#acknowledged, [key]: alert.since };
    sessionStorage.setItem(KEY, JSON.stringify(this.#acknowledged));
    this.#show();
  }

  async #look() {
    const { rest, cloud } = this.#context;
    const maps = [...new Set([...cloud.robots.map(({ map }) => map), cloud.map])].filter((id) => id !== null && !isNew(id));
    const gone = refused(404, () => []); // the map was removed meanwhile, or is not shown to the user
    const paths = maps.map((id) => `v1/maps/${encodeURIComponent(id)}/tasks?state=failed`);
    this.#tasks = (await Promise.all(paths.map((path) => rest.list(path).catch(gone)))).flat();
    if (cloud.isAdmin) await this.#readEnds();
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
      ...failedGoals(fleet.links), ...failedTasks(this.#tasks, cloud.now),
    ];
    this.#seen = new Map(found.map(({ key, since }) => [key, since ?? this.#seen.get(key) ?? cloud.now]));
    const dated = found.map((alert) => ({ ...alert, since: this.#seen.get(alert.key) }));
    const shown = dated.filter(({ key, since }) => (this.#acknowledged[key] ?? -Infinity) < since);
    this.alerts = shown.sort((a, b) => b.since - a.since || a.key.localeCompare(b.key));
  }
}
