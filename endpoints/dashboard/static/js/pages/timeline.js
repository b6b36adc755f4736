/** Timeline of what was done in the cloud and seen of robots: filtered, live, and as far back as is asked for. */

import { make, say, show } from "../dom.js";
import { KINDS, chosen, lineOf, lineOfEntry, pathOf, timeText } from "./event_words.js";

const PAGE = 100; // events that are read at once
const TITLES = ["When", "Who", "What", "On", "Details"];

export class Timeline {
  #context;
  /** @type {Map<number, import("./event_words.js").Line>} by number of the event */ #lines = new Map();
  #newest = null;
  #older = null;
  /** What is read now; another one ends the reads of the one before. */ #asked = {};
  #kind = make("select", { name: "kind" }, ...Object.entries(KINDS).map(([value, textContent]) => make("option", { value, textContent })));
  #robot = filter("robot", "tb1");
  #user = filter("user", "ann");
  #note = make("p", { className: "muted", role: "status" });
  #body = make("tbody");
  #more = make("button", { className: "button", type: "button", textContent: "Older", hidden: true, onclick: () => this.#readOlder() });
  element = make("section", { "aria-label": "Timeline" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#kind.addEventListener("change", () => this.#show());
    for (const input of [this.#robot, this.#user]) input.addEventListener("change", () => this.#restart());
    const filters = make("form", { className: "fields", role: "search", "aria-label": "Filter the timeline" },
      make("label", {}, "Kind", this.#kind), make("label", {}, "Robot", this.#robot), make("label", {}, "User", this.#user));
    filters.addEventListener("submit", (event) => event.preventDefault());
    const head = make("thead", {}, make("tr", {}, ...TITLES.map((textContent) => make("th", { scope: "col", textContent }))));
    const table = make("table", {}, make("caption", { className: "unseen", textContent: "Events, the newest first" }), head, this.#body);
    this.element.append(make("h3", { textContent: "Timeline" }), filters, this.#note,
      make("div", { className: "table", role: "region", "aria-label": "Table of events", tabIndex: 0 }, table), this.#more);
  }

  get #wanted() {
    return { kind: this.#kind.value, robot: this.#robot.value.trim(), user: this.#user.value.trim() };
  }

  /** Read what is new. */
  async poll() {
    const { rest, cloud } = this.#context;
    const asked = this.#asked;
    if (cloud.isAdmin) {
      const after = this.#newest === null ? {} : { after: this.#newest };
      const answer = await rest.get(pathOf(this.#wanted, { limit: PAGE, ...after }));
      if (asked !== this.#asked) return; // the filter was changed meanwhile
      if (this.#newest === null || answer.next) this.#begin(answer.next); // more than a page is new: none may be missing between
      this.#take(answer.items);
    }
    this.#show();
  }

  async #readOlder() {
    const asked = this.#asked;
    this.#more.disabled = true;
    try {
      const answer = await this.#context.rest.get(pathOf(this.#wanted, { limit: PAGE, cursor: this.#older }));
      if (asked !== this.#asked) return;
      this.#older = answer.next;
      this.#take(answer.items);
      this.#show();
    } catch (error) {
      this.#context.failed(error);
    } finally {
      this.#more.disabled = false;
    }
  }

  /** Forget the lines, and where older ones begin. */
  #begin(older) {
    this.#lines.clear();
    this.#older = older;
  }

  #take(items) {
    for (const event of items) this.#lines.set(event.number, lineOf(event));
    this.#newest = Math.max(this.#newest ?? 0, ...items.map(({ time }) => time));
  }

  async #restart() {
    this.#asked = {};
    this.#begin(null);
    this.#newest = null;
    await this.poll().catch((error) => this.#context.failed(error));
  }

  #show() {
    const { cloud, journal } = this.#context;
    const lines = chosen([...this.#lines.values(), ...journal.entries.map(lineOfEntry)], this.#wanted);
    const source = cloud.isAdmin ? "Changes, connections and refusals of the audit log, and what this page sees of robots" : "What this page sees of your robots; administrators see the audit log, too";
    say(this.#note, lines.length ? source : `Nothing yet. ${source}`);
    show(this.#body, lines, ({ key }) => key, createLine, (row, line) => fillLine(row, line, cloud.now));
    this.#more.hidden = !this.#older;
  }
}

function filter(name, placeholder) {
  return make("input", { name, type: "search", placeholder, maxLength: 128, autocapitalize: "none", spellcheck: false });
}

function createLine({ key }) {
  return make("tr", { className: key.startsWith("seen") ? "seen" : "" }, ...TITLES.map(() => make("td")));
}

function fillLine(row, { time, who, what, object, outcome, details }, now) {
  row.dataset.outcome = outcome;
  [timeText(time, now), who, outcome === "ok" ? what : `${what}: ${outcome}`, object, details].forEach((text, i) => say(row.children[i], text));
}
