/** The users of the cloud, for administrators: create, change, lock and remove them. */

import { make, say, show } from "../dom.js";
import { orderForm } from "../order_form.js";
import { namesOf, unknownPassword } from "./access_words.js";

const ROLES = { user: "User", admin: "Administrator" };
const PASSWORD = { type: "password", autocomplete: "new-password", required: true, minLength: 8, maxLength: 1024 };

function roleSelect(properties = {}) {
  return make("select", { name: "role", ...properties }, ...Object.entries(ROLES).map(([value, textContent]) => make("option", { value, textContent })));
}

export class UsersPanel {
  #context;
  #list = make("ul", { className: "list cards" });
  #error = make("p", { className: "error", role: "alert" });
  #name = make("input", { name: "id", required: true, maxLength: 64, autocomplete: "off", autocapitalize: "none", spellcheck: false });
  #password = make("input", { name: "password", ...PASSWORD });
  #role = roleSelect();
  #groups = make("input", { name: "groups", maxLength: 2000, autocapitalize: "none", spellcheck: false });
  element = make("section", { "aria-label": "Users", hidden: true });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    const form = orderForm("Create a user", "Create", () => this.#create(), make("div", { className: "fields" }, make("label", {}, "Name", this.#name),
      make("label", {}, "Password, 8 characters or more", this.#password), make("label", {}, "Role", this.#role), make("label", {}, "Groups", this.#groups)), this.#error);
    this.element.append(make("h3", { textContent: "Users" }), make("details", { className: "go" }, make("summary", { textContent: "Create a user" }), form), this.#list);
  }

  async poll() {
    this.element.hidden = !this.#context.cloud.isAdmin;
    if (this.element.hidden) return;
    const users = await this.#context.rest.list("v1/users");
    show(this.#list, users, ({ id }) => id, (user) => this.#createItem(user), fill);
  }

  #createItem({ id }) {
    const self = id === this.#context.cloud.me.id;
    const role = roleSelect({ "aria-label": `Role of ${id}`, disabled: self, onchange: () => this.#change(id, { role: role.value }, `${id} is ${ROLES[role.value].toLowerCase()} now`) });
    const actions = make("div", { className: "actions" }, act("Log out", `Log ${id} out everywhere`, () => this.#logOut(id)));
    if (!self) actions.append(this.#passwordForm(id), act("Lock", `Lock ${id}`, () => this.#lock(id)), act("Remove", `Remove ${id}`, () => this.#remove(id), true));
    return make("li", { className: "review" }, make("span", { className: "name", textContent: self ? `${id}, you` : id }), role, make("span", { className: "muted" }), actions);
  }

  #passwordForm(id) {
    const password = make("input", { name: "password", ...PASSWORD });
    const form = orderForm(`New password of ${id}`, "Set", () => this.#change(id, { password: password.value }, `${id} has a new password, and no tokens`), make("label", {}, "New password", password));
    return make("details", { className: "go" }, make("summary", { textContent: "New password" }), form);
  }

  #path(id, more = "") {
    return `v1/users/${encodeURIComponent(id)}${more}`;
  }

  #change(id, change, done) {
    return this.#context.ask(this.#context.rest.patch(this.#path(id), change), done);
  }

  #logOut(id) {
    if (!confirm(`Log ${id} out everywhere? All tokens end, also those of robots, which are disconnected.`)) return;
    this.#context.ask(this.#context.rest.delete(this.#path(id, "/sessions")), `${id} is logged out everywhere`);
  }

  #lock(id) {
    if (!confirm(`Lock ${id}? The user gets a password that nobody knows; all tokens and connections end, also those of robots. A new password unlocks.`)) return;
    const { rest, ask } = this.#context;
    const order = async () => {
      await rest.patch(this.#path(id), { password: unknownPassword() });
      await rest.delete(this.#path(id, "/sessions"));
    };
    ask(order(), `${id} is locked`);
  }

  #remove(id) {
    if (!confirm(`Remove ${id}, with all tokens and robots, also those that drive now?`)) return;
    this.#context.ask(this.#context.rest.delete(this.#path(id, "?force=true")), `${id} is removed`);
  }

  async #create() {
    say(this.#error, "");
    const user = { id: this.#name.value.trim(), password: this.#password.value, role: this.#role.value, groups: namesOf(this.#groups.value) };
    try {
      await this.#context.rest.post("v1/users", user);
      this.#name.value = this.#password.value = this.#groups.value = "";
      await this.poll();
    } catch (error) {
      say(this.#error, error.message);
    }
  }
}

function act(textContent, label, onclick, stop = false) {
  return make("button", { className: stop ? "button stop" : "button", type: "button", textContent, "aria-label": label, onclick });
}

function fill(item, { role, groups }) {
  const select = item.children[1];
  if (document.activeElement !== select) select.value = role; // else the user chooses another one
  say(item.children[2], groups.length ? `In ${groups.join(", ")}` : "In no group");
}
