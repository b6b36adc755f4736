/** The user's tasks on a map. Of hundreds that have ended, only those that end now are read again. */

import { isOpen } from "./task_words.js";

const WHOLE = 30; // time between two looks at all tasks [s]
const ONE_BY_ONE = 20; // tasks that ended since the last look; more are read with all others

export class TaskList {
  /** @type {object[]} */ tasks = [];
  #rest;
  #path = null;
  #readAt = -Infinity;

  /** @param {import("../rest.js").Rest} rest */
  constructor(rest) {
    this.#rest = rest;
  }

  /** Read the tasks of a map. @param {string | null} path of its tasks, null for none @param {number} now [s] */
  async read(path, now) {
    if (path !== this.#path) this.#forget(path);
    if (path === null) return;
    const whole = now - this.#readAt >= WHOLE;
    const found = whole ? await this.#rest.list(path) : await this.#changed(path);
    if (path !== this.#path) return; // another map was chosen meanwhile
    if (whole) this.#readAt = now;
    this.tasks = found;
  }

  async #changed(path) {
    const open = await this.#rest.list(`${path}?state=open`);
    const ids = new Set(open.map(({ id }) => id));
    const gone = this.tasks.filter((task) => isOpen(task) && !ids.has(task.id));
    if (gone.length > ONE_BY_ONE) return this.#rest.list(path);
    const ended = await Promise.all(gone.map(({ id }) => this.#rest.get(`${path}/${encodeURIComponent(id)}`)));
    return [...this.tasks.filter((task) => !isOpen(task)), ...ended, ...open];
  }

  #forget(path) {
    this.#path = path;
    this.#readAt = -Infinity;
    this.tasks = [];
  }
}
