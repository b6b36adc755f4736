/** Page with the Path Plan Database of the shown map: the last paths, and how often stored ones were used again. */

import { make, say, show } from "../dom.js";
import { bytes } from "../format.js";
import { isNew } from "../growing_map.js";
import { addPage } from "../registry.js";
import { timeText } from "./event_words.js";
import { OF_PLAN, OF_PLANNER, reuseText, storedText } from "./plan_words.js";

const MOST = 50;

class PlansPage {
  #context;
  #note = make("p", { className: "muted", role: "status" });
  #planners = table("Planners", OF_PLANNER);
  #plans = table("The last paths, the newest first", OF_PLAN);
  #parts = make("div", { className: "page-parts" });
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#parts.append(make("section", { "aria-label": "Planners" }, make("h3", { textContent: "Planners" }), this.#planners.element),
      make("section", { "aria-label": "Paths" }, make("h3", { textContent: "Last paths" }), this.#plans.element));
    this.element.append(this.#note, this.#parts);
  }

  async poll() {
    const { rest, cloud } = this.#context;
    const { map } = cloud;
    this.#parts.hidden = map === null || isNew(map);
    if (this.#parts.hidden) return say(this.#note, "Choose a map above: paths are stored by map.");
    const path = `v1/maps/${encodeURIComponent(map)}`;
    const [{ planners }, statistics, { items }] = await Promise.all([rest.get(`${path}/evaluation`), rest.get(`${path}/plan_statistics`), rest.get(`${path}/plans?limit=${MOST}`)]);
    if (map !== cloud.map) return; // another one was chosen meanwhile
    say(this.#note, `${storedText(statistics, bytes)}. ${reuseText(planners)}`);
    this.#planners.show(planners, ({ planner }) => planner, "");
    this.#plans.show(items, ({ plan_id: id }) => id, ({ created }) => timeText(created, cloud.now));
  }
}

/** A table of things, with the text of each column. @param {string} caption @param {[string, (thing: object, when: string) => string][]} columns */
function table(caption, columns) {
  const body = make("tbody");
  const head = make("thead", {}, make("tr", {}, ...columns.map(([textContent]) => make("th", { scope: "col", textContent }))));
  const whole = make("table", {}, make("caption", { className: "unseen", textContent: caption }), head, body);
  return {
    element: make("div", { className: "table", role: "region", "aria-label": caption, tabIndex: 0 }, whole),
    show: (things, keyOf, whenOf) => show(body, things, keyOf, () => make("tr", {}, ...columns.map(() => make("td"))), (row, thing) => {
      columns.forEach(([, text], i) => say(row.children[i], text(thing, whenOf && whenOf(thing))));
    }),
  };
}

addPage({ id: "plans", title: "Plans", order: 5, create: (context) => new PlansPage(context) });
