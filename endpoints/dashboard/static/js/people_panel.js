/** Panel of the people on the shown map: who is seen, who follows whom and why, and the settings. */

import { byId, make, say, show } from "./dom.js";
import { plural } from "./format.js";
import { orderForm } from "./order_form.js";
import { nameOf } from "./people_state.js";

const RULES = { nearest: "The nearest person", named: "The people picked here", longest_seen: "Who has been seen longest" };
const STATES = { seen: "seen", predicted: "hidden", lost: "lost" };
const FULL = 1000;

/** What is known of a person, in words. @param {object} person @param {{robot: string, reason: string} | null} order */
export function doing({ seen_by: frames, group }, order) {
  const parts = [];
  if (order) parts.push(`Followed by ${order.robot}${order.reason && `: ${order.reason}`}`);
  if (frames.length) parts.push(`seen as ${frames.join(", ")}`);
  if (group) parts.push(`talks (group ${group})`);
  const text = parts.join("; ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** The state of the coordinator and of robots that are not trusted, in words; empty if all is well. */
export function noteOf({ coordinator, reason, robots }) {
  if (coordinator !== "ready") return `People are not counted now: ${reason || "their container starts"}`;
  return robots.filter(({ trusted }) => !trusted).map(({ robot, reason: why }) => `${robot} is not trusted: ${why}`).join("; ");
}

export class PeoplePanel {
  #panel = byId("panel-people");
  #orders;
  #rule = make("select", { name: "rule" });
  #atOnce = make("input", { name: "at-once", type: "number", min: 0, max: FULL, step: 1, inputMode: "numeric" });
  #history = make("input", { type: "checkbox", role: "switch", id: "people-history" });

  /**
   * @param {{follow: (id: number) => void, pick: (id: number) => void, colourOf: (id: number) => string,
   *          change: (settings: object) => Promise<void>}} orders
   */
  constructor(orders) {
    this.#orders = orders;
    this.#rule.addEventListener("change", () => orders.change({ rule: this.#rule.value }));
    this.#atOnce.addEventListener("change", () => this.#atOnce.reportValidity() && orders.change({ followed_at_once: this.#atOnce.valueAsNumber }));
    this.#history.addEventListener("change", () => orders.change({ history: this.#history.checked }));
    byId("people-settings").append(
      make("summary", { textContent: "Whom robots follow" }),
      make("div", { className: "name-form" }, make("label", {}, "Rule", this.#rule), make("label", {}, "Most people followed at once", this.#atOnce),
        make("label", { className: "switch" }, this.#history, "Count people by hour")),
    );
  }

  /** @param {import("./people_state.js").PeopleState} state */
  update(state) {
    this.#panel.hidden = !state.active;
    if (this.#panel.hidden) return;
    const { people, count } = state.answer;
    say(byId("people-count"), String(count));
    say(byId("people-note"), noteOf(state.answer));
    show(byId("people"), people, ({ id }) => String(id), (person) => this.#create(person), (item, person) => this.#fill(item, person, state));
    if (state.settings) this.#showSettings(state.settings, state.answer.rules);
  }

  #create({ id, name }) {
    const input = make("input", { name: "name", value: name, maxLength: 64 });
    const naming = orderForm("Name the person", "Name", () => this.#orders.change({ names: { [id]: input.value || null } }), make("label", {}, "Name", input));
    const head = make("button", { className: "robot", type: "button", onclick: () => this.#orders.pick(id) },
      make("span", { className: "swatch" }), make("span", { className: "name" }), make("span", { className: "presence" }), make("span", { className: "doing" }));
    const follow = make("button", { className: "button", type: "button", onclick: () => this.#orders.follow(id) });
    const more = make("div", { className: "person-actions" }, follow, make("details", { className: "go" }, make("summary", { textContent: "Name" }), naming));
    return make("li", {}, head, more);
  }

  #fill(item, person, state) {
    const [head, more] = item.children;
    const [swatch, name, presence, what] = head.children;
    swatch.style.background = this.#orders.colourOf(person.id);
    say(name, nameOf(person));
    presence.dataset.presence = { seen: "online", predicted: "silent", lost: "offline" }[person.state];
    say(presence, STATES[person.state] ?? person.state);
    say(what, doing(person, state.order(person.id)));
    what.title = what.textContent;
    head.setAttribute("aria-pressed", String(state.picked === person.id));
    more.hidden = state.picked !== person.id;
    say(more.firstChild, state.isTarget(person.id) ? "Do not follow" : "Follow");
  }

  /** Show the settings, except in a field that the user is about to change. */
  #showSettings({ rule, followed_at_once: atOnce, history, zones }, rules) {
    show(this.#rule, rules, (name) => name, (name) => make("option", { value: name, textContent: RULES[name] ?? name }), () => {});
    const free = (field) => document.activeElement !== field;
    if (free(this.#rule)) this.#rule.value = rule;
    if (free(this.#atOnce)) this.#atOnce.value = String(atOnce);
    if (free(this.#history)) this.#history.checked = history;
    this.#history.parentElement.title = zones.length ? `In ${plural(zones.length, "zone")}, and on the whole map` : "On the whole map";
  }
}
