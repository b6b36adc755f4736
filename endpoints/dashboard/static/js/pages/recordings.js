/** Page with the recordings of all robots: download one, or delete it. */

import { make, say, show } from "../dom.js";
import { plural } from "../format.js";
import { fileOf, noteOf, save, titleOf } from "../recordings.js";
import { addPage } from "../registry.js";
import { refused } from "../rest.js";
import { RecordingList, matches, sumOf } from "./recording_list.js";

const TITLES = ["Robot", "Begun", "Size", ""];

class RecordingsPage {
  #context;
  #list;
  #note = make("p", { className: "muted", role: "status" });
  #search = make("input", { name: "robot", type: "search", placeholder: "tb1", maxLength: 128, autocapitalize: "none", spellcheck: false });
  #body = make("tbody");
  #table = make("div", { className: "table", role: "region", "aria-label": "Recordings", tabIndex: 0 });
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    const { rest } = context;
    const none = refused(404, () => []); // the robot was removed meanwhile
    this.#list = new RecordingList((id) => rest.list(path(id)).catch(none));
    this.#search.addEventListener("input", () => this.#show());
    const filter = make("form", { className: "fields", role: "search", "aria-label": "Filter the recordings" }, make("label", {}, "Robot", this.#search));
    filter.addEventListener("submit", (event) => event.preventDefault());
    const head = make("thead", {}, make("tr", {}, ...TITLES.map((textContent) => make(textContent ? "th" : "td", { textContent, ...(textContent && { scope: "col" }) }))));
    this.#table.append(make("table", {}, make("caption", { className: "unseen", textContent: "Recordings, the newest first" }), head, this.#body));
    this.element.append(filter, this.#note, this.#table);
  }

  async poll() {
    await this.#list.read(this.#context.cloud.robots.map(({ id }) => id), performance.now() / 1000, () => this.#show());
    this.#show();
  }

  #show() {
    const { robots } = this.#context.cloud;
    const found = this.#list.recordings.filter((one) => matches(one, this.#search.value));
    const { done } = this.#list;
    const progress = done < robots.length ? `; ${done} of ${plural(robots.length, "robot")} read` : "";
    say(this.#note, (found.length ? sumOf(found) : "No recordings. Start one in the card of a robot, with “Recordings”") + progress);
    this.#table.hidden = !found.length;
    show(this.#body, found, ({ robot, id }) => `${robot} ${id}`, (one) => this.#create(one), (row, one) => {
      [one.robot, titleOf(one.id), noteOf(one, one.id)].forEach((text, i) => say(row.children[i], text));
    });
  }

  #create({ robot, id }) {
    const role = this.#context.cloud.robots.find((one) => one.id === robot)?.role;
    const actions = [button("Download", `Download ${titleOf(id)} of ${robot}`, () => this.#download(robot, id))];
    if (role === "administer") actions.push(button("Delete", `Delete ${titleOf(id)} of ${robot}`, () => this.#delete(robot, id), true));
    return make("tr", { "data-outcome": "ok" }, make("td"), make("td"), make("td"), make("td", {}, make("div", { className: "actions" }, ...actions)));
  }

  #download(robot, id) {
    const { rest, ask } = this.#context;
    const order = async () => save(await rest.blob(`${path(robot)}/${encodeURIComponent(id)}/file`), fileOf(robot, id));
    return ask(order(), `${titleOf(id)} of ${robot} is fetched`);
  }

  #delete(robot, id) {
    if (!confirm(`Delete the recording of ${robot}, ${titleOf(id)}?`)) return;
    this.#list.forget();
    this.#context.ask(this.#context.rest.delete(`${path(robot)}/${encodeURIComponent(id)}`), `${titleOf(id)} of ${robot} is deleted`);
  }
}

function path(robot) {
  return `v1/robots/${encodeURIComponent(robot)}/recordings`;
}

function button(textContent, label, onclick, stop = false) {
  return make("button", { className: stop ? "button stop" : "button", type: "button", textContent, "aria-label": label, onclick });
}

addPage({ id: "recordings", title: "Recordings", order: 6, create: (context) => new RecordingsPage(context) });
