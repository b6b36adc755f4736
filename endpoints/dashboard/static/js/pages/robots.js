/** Page with the user's robots: add one with its token, give it another one, or remove it. */

import { make, say, show } from "../dom.js";
import { isNew } from "../growing_map.js";
import { orderForm } from "../order_form.js";
import { addPage } from "../registry.js";
import { Refused, refused } from "../rest.js";
import { DAY, variablesOf } from "./access_words.js";
import { OneTime } from "./one_time.js";

const DAYS = 366; // for which a token of a robot is good, the longest that the cloud allows

class RobotsPage {
  #context;
  #secret = new OneTime();
  #name = make("input", { name: "id", required: true, maxLength: 64, autocapitalize: "none", spellcheck: false, placeholder: "tb1" });
  #map = make("select", { name: "map", required: true });
  #model = make("select", { name: "model" });
  #pose = ["x [m]", "y [m]", "Heading [°]"].map((text) => ({ text, input: make("input", { type: "number", step: "any", value: 0, inputMode: "decimal" }) }));
  #error = make("p", { className: "error", role: "alert" });
  #list = make("ul", { className: "list cards" });
  #none = make("p", { className: "empty", textContent: "You have no robot yet." });
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    const fields = make("div", { className: "fields" }, make("label", {}, "Name", this.#name), make("label", {}, "Map", this.#map), make("label", {}, "Model", this.#model));
    const pose = make("fieldset", { className: "fields" }, make("legend", { textContent: "Where it starts" }), ...this.#pose.map(({ text, input }) => make("label", {}, text, input)));
    const form = orderForm("Add a robot", "Add, and create its token", () => this.#add(), fields, pose, this.#error);
    this.element.append(make("details", { className: "go" }, make("summary", { textContent: "Add a robot" }), form), this.#none, this.#list);
  }

  update() {
    const { cloud } = this.#context;
    fillSelect(this.#map, cloud.maps.map(({ id }) => id));
    fillSelect(this.#model, [...cloud.radii.keys()]);
    const mine = cloud.robots.filter(({ role }) => role === "administer").sort((a, b) => a.id.localeCompare(b.id, undefined, { numeric: true }));
    this.#none.hidden = mine.length > 0;
    show(this.#list, mine, ({ id }) => id, (robot) => this.#create(robot), (item, { map, model, connected }) => {
      const [presence, where] = item.children[1].children;
      presence.dataset.presence = connected ? "online" : "offline";
      say(presence, connected === null ? "unknown" : connected ? "connected" : "not connected");
      say(where, `${model} on ${map}`);
    });
  }

  #create({ id }) {
    const actions = make("div", { className: "actions" });
    const act = (text, label, order, stop) => actions.append(make("button", { className: stop ? "button stop" : "button", type: "button", textContent: text, "aria-label": label, onclick: order }));
    if (!isNew(this.#robot(id).map)) act("Show", `Show ${id} on the map`, () => this.#context.goTo(this.#robot(id)));
    if (!id.includes(":")) act("New token", `New token for ${id}`, () => this.#newToken(id)); // the owner alone gives it one
    act("Remove", `Remove ${id}`, () => this.#remove(id), true);
    return make("li", { className: "review" }, make("span", { className: "name", textContent: id }), make("p", {}, make("span", { className: "presence" }), " ", make("span", { className: "muted" })), actions);
  }

  #robot(id) {
    return this.#context.cloud.robots.find((robot) => robot.id === id);
  }

  #path(id) {
    return `v1/robots/${encodeURIComponent(id)}`;
  }

  async #add() {
    say(this.#error, "");
    const id = this.#name.value.trim();
    const [x, y, heading] = this.#pose.map(({ input }) => input.valueAsNumber || 0);
    try {
      await this.#checkFree(id);
      await this.#context.rest.put(this.#path(id), { map: this.#map.value, model: this.#model.value, initial_pose: [x, y, (heading * Math.PI) / 180] }, null, "application/json");
      await this.#showToken(id);
      this.#name.value = "";
      await this.#context.ask(Promise.resolve(), `${id} is added`);
    } catch (error) {
      say(this.#error, error.message);
    }
  }

  /** Refuse a name that is taken: a robot's file would be replaced. */
  async #checkFree(id) {
    const found = await this.#context.rest.get(this.#path(id)).catch(refused(404, () => null));
    if (found) throw new Refused(409, `There is a robot ${id} already`);
  }

  async #newToken(id) {
    await this.#showToken(id).catch((error) => this.#context.ask(Promise.reject(error), ""));
  }

  async #showToken(id) {
    const { token } = await this.#context.rest.post("v1/scoped-tokens", { name: `robot ${id}`, robots: [id], role: "robot", expires_in: DAYS * DAY });
    this.#secret.show(`Token of robot ${id}`, variablesOf(cloudUrl(), token));
  }

  #remove(id) {
    if (!confirm(`Remove ${id}, with its recordings, its shares, and the tokens for it alone?`)) return;
    this.#context.ask(this.#context.rest.delete(this.#path(id)), `${id} is removed`);
  }
}

/** Root of the cloud, which a proxy may serve below a path. */
function cloudUrl() {
  return new URL("..", location.href.split("#")[0]).href.replace(/\/$/, "");
}

function fillSelect(select, values) {
  show(select, values, (value) => value, (value) => make("option", { value, textContent: value }), () => {});
}

addPage({ id: "robots", title: "Robots", order: 3, create: (context) => new RobotsPage(context) });
