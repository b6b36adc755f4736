/** The user's tokens: list, revoke, and create one for some robots, whose text is shown once. */

import { make, say, show } from "../dom.js";
import { orderForm } from "../order_form.js";
import { DAY, expiryText, namesOf, scopeText } from "./access_words.js";
import { OneTime } from "./one_time.js";

const ROLES = { look: "Look", drive: "Drive", administer: "Administer", robot: "Connect as the robot itself" };

export class TokensPanel {
  #context;
  #secret = new OneTime();
  #list = make("ul", { className: "list cards" });
  #error = make("p", { className: "error", role: "alert" });
  #name = make("input", { name: "name", maxLength: 100, required: true, placeholder: "display in the hall" });
  #robots = make("input", { name: "robots", required: true, maxLength: 2000, placeholder: "tb*", autocapitalize: "none", spellcheck: false });
  #role = make("select", { name: "role" }, ...Object.entries(ROLES).map(([value, textContent]) => make("option", { value, textContent })));
  #days = make("input", { name: "days", type: "number", min: 1, max: 366, step: 1, value: 30, required: true, inputMode: "numeric" });
  element = make("section", { "aria-label": "Your tokens" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    const form = orderForm("Create a token", "Create", () => this.#create(), make("label", {}, "What it is for", this.#name),
      make("div", { className: "fields" }, make("label", {}, "Robots, such as tb1 or tb*", this.#robots), make("label", {}, "It may", this.#role), make("label", {}, "Days", this.#days)), this.#error);
    this.element.append(make("h3", { textContent: "Your tokens" }),
      make("details", { className: "go" }, make("summary", { textContent: "Create a token for some robots" }), form), this.#list);
  }

  async poll() {
    const tokens = await this.#context.rest.list("v1/tokens");
    const { now } = this.#context.cloud;
    const order = (a, b) => Number(b.current) - Number(a.current) || b.created - a.created;
    show(this.#list, tokens.sort(order), ({ id }) => id, (token) => this.#createItem(token), (item, token) => {
      say(item.children[1], scopeText(token));
      say(item.children[2], expiryText(token, now));
    });
  }

  #createItem({ id, name, current, scope }) {
    const title = name || (current ? "This login" : scope ? "Token" : "Login");
    const revoke = make("button", { className: "button stop", type: "button", textContent: "Revoke", "aria-label": `Revoke ${title}`, hidden: current, onclick: () => this.#revoke(id, title) });
    return make("li", { className: "review" }, make("span", { className: "name", textContent: title }), make("span"), make("span", { className: "muted" }), make("div", { className: "actions" }, revoke));
  }

  #revoke(id, title) {
    if (!confirm(`Revoke “${title}”? What uses it is disconnected at once.`)) return;
    this.#context.ask(this.#context.rest.delete(`v1/tokens/${encodeURIComponent(id)}`), `${title} is revoked`);
  }

  async #create() {
    say(this.#error, "");
    const wanted = { name: this.#name.value, robots: namesOf(this.#robots.value), role: this.#role.value, expires_in: this.#days.valueAsNumber * DAY };
    try {
      const { token } = await this.#context.rest.post("v1/scoped-tokens", wanted);
      this.#secret.show(`Token: ${wanted.name}`, token);
      this.#name.value = this.#robots.value = "";
      await this.poll();
    } catch (error) {
      say(this.#error, error.message);
    }
  }
}
