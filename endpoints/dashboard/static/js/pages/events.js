/** Page with what wakes a person, and with what was done and seen, in order of time. */

import { make, say, show } from "../dom.js";
import { duration } from "../format.js";
import { addPage } from "../registry.js";
import { AlertWatch } from "./alert_watch.js";
import { Timeline } from "./timeline.js";

class EventsPage {
  #context;
  #watch;
  #timeline;
  #note = make("p", { className: "muted", role: "status" });
  #list = make("ul", { className: "list alerts", "aria-label": "Alerts" });
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#watch = new AlertWatch(context);
    this.#timeline = new Timeline(context);
    this.element.append(make("section", { "aria-label": "Alerts" }, make("h3", { textContent: "Alerts" }), this.#note, this.#list), this.#timeline.element);
  }

  /** Number of alerts. */
  get count() {
    return this.#watch.alerts.length;
  }

  poll() {
    return this.#timeline.poll();
  }

  update() {
    this.#watch.update();
    this.#show();
  }

  #show() {
    const { alerts } = this.#watch;
    const { now } = this.#context.cloud;
    say(this.#note, alerts.length ? "" : "Nothing needs you now.");
    show(this.#list, alerts, ({ key }) => key, (alert) => this.#create(alert), (item, { text, advice, since }) => {
      const [name, what, age] = item.children;
      say(name, text);
      say(what, advice);
      say(age, `for ${duration(Math.max(0, now - since))}`);
    });
  }

  #create({ key, robot, text }) {
    const actions = make("div", { className: "actions" });
    const known = this.#context.cloud.robots.find(({ id }) => id === robot);
    if (known) actions.append(button("Look", `Look at ${robot}`, () => this.#context.goTo(known)));
    actions.append(button("Acknowledge", `Acknowledge: ${text}`, () => this.#acknowledge(key)));
    return make("li", { className: "finding", "data-level": "error" }, make("p", { className: "text" }), make("p"), make("p", { className: "muted" }), actions);
  }

  #acknowledge(key) {
    this.#watch.acknowledge(key);
    this.#show();
  }
}

function button(textContent, label, onclick) {
  return make("button", { className: "button", type: "button", textContent, "aria-label": label, onclick });
}

addPage({ id: "events", title: "Events", order: 2, create: (context) => new EventsPage(context) });
