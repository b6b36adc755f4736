/** Page with what wakes a person, and with what was done and seen, in order of time. */

import { make, say, show } from "../dom.js";
import { duration } from "../format.js";
import { addPage } from "../registry.js";
import { AlertWatch } from "./alert_watch.js";
import { mayAcknowledge } from "./alert_words.js";
import { Timeline } from "./timeline.js";

class EventsPage {
  #context;
  #watch;
  #timeline;
  #note = make("p", { className: "muted", role: "status" });
  #list = make("ul", { className: "list alerts", "aria-label": "Alerts" });
  #title = make("summary");
  #old = make("ul", { className: "list alerts", "aria-label": "Acknowledged alerts" });
  #seenTo = make("details", { className: "go" }, this.#title, this.#old);
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#watch = new AlertWatch(context);
    this.#timeline = new Timeline(context);
    this.element.append(make("section", { "aria-label": "Alerts" }, make("h3", { textContent: "Alerts" }), this.#note, this.#list, this.#seenTo), this.#timeline.element);
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
    const { alerts, acknowledged } = this.#watch;
    const { now } = this.#context.cloud;
    const age = (time) => duration(Math.max(0, now - time));
    say(this.#note, alerts.length ? "" : "Nothing needs you now.");
    const since = ({ since: begin, earlier }) => `for ${age(begin)}${earlier ? " or longer" : ""}`;
    this.#fill(this.#list, alerts, since);
    this.#seenTo.hidden = !acknowledged.length;
    say(this.#title, `Acknowledged (${acknowledged.length})`);
    this.#fill(this.#old, acknowledged, (alert) => `${since(alert)}; acknowledged by ${alert.by} ${age(alert.time)} ago`);
  }

  #fill(list, alerts, noteOf) {
    show(list, alerts, ({ key }) => key, (alert) => this.#create(alert, list === this.#list), (item, alert) => {
      const [name, what, note] = item.children;
      say(name, alert.text);
      say(what, alert.advice);
      say(note, noteOf(alert));
    });
  }

  #create(alert, isOpen) {
    const { key, robot, text } = alert;
    const { cloud, goTo } = this.#context;
    const actions = make("div", { className: "actions" });
    const known = cloud.robots.find(({ id }) => id === robot);
    if (known) actions.append(button("Look", `Look at ${robot}`, () => goTo(known)));
    if (isOpen && mayAcknowledge(alert, cloud.robots, cloud.isAdmin)) actions.append(button("Acknowledge", `Acknowledge: ${text}`, () => this.#acknowledge(key)));
    return make("li", { className: "finding", "data-level": isOpen ? "error" : "seen" }, make("p", { className: "text" }), make("p"), make("p", { className: "muted" }), actions);
  }

  async #acknowledge(key) {
    await this.#context.ask(this.#watch.acknowledge(key), "Acknowledged for all whom it concerns");
    this.#show();
  }
}

function button(textContent, label, onclick) {
  return make("button", { className: "button", type: "button", textContent, "aria-label": label, onclick });
}

addPage({ id: "events", title: "Events", order: 2, create: (context) => new EventsPage(context) });
