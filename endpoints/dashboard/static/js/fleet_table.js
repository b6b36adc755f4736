/** Dialog with a table of all robots of the user, on whichever map. It draws the visible rows only, so that hundreds stay fluent. */

import { byId, make, say, show } from "./dom.js";
import { COLUMNS, matching, rowOf, sorted, windowOf } from "./fleet_rows.js";
import { plural } from "./format.js";

/** Names of states in parts.css, where these differ. */
const PRESENCE = { "no signal": "silent" };
const ROW = 44; // height of a row, as in parts.css [pixels]

export class FleetTable {
  #dialog = byId("fleet");
  #scroller = byId("fleet-rows");
  #search = byId("fleet-search");
  #body = make("tbody");
  #table = make("table", {}, make("caption", { className: "unseen", textContent: "Robots" }));
  #above = make("div");
  #below = make("div");
  #heads;
  #key = "id";
  #falls = false;
  #picked;
  /** @type {object[]} as the cloud lists them */ #robots = [];
  /** @type {import("./fleet_rows.js").Row[]} the rows that are found, in order */ #rows = [];

  /** @param {(robot: {id: string, map: string}) => void} picked */
  constructor(picked) {
    this.#picked = picked;
    this.#heads = COLUMNS.map(([key, title]) => make("th", { scope: "col" }, make("button", { type: "button", textContent: title, onclick: () => this.#sort(key) })));
    this.#table.append(make("thead", {}, make("tr", {}, ...this.#heads)), this.#body);
    this.#scroller.replaceChildren(this.#above, this.#table, this.#below);
    this.#scroller.addEventListener("scroll", () => this.#draw());
    this.#search.addEventListener("input", () => this.#begin());
    byId("fleet-open").addEventListener("click", () => this.#open());
    byId("fleet-close").addEventListener("click", () => this.#dialog.close());
  }

  /** Take what the cloud lists. @param {object[]} robots of all maps */
  take(robots) {
    this.#robots = robots;
    if (this.#dialog.open) this.#find();
  }

  #open() {
    this.#dialog.showModal();
    this.#begin();
    this.#search.focus();
  }

  /** Show the first rows. */
  #begin() {
    this.#scroller.scrollTop = 0;
    this.#find();
  }

  #sort(key) {
    this.#falls = key === this.#key && !this.#falls;
    this.#key = key;
    this.#begin();
  }

  #find() {
    const all = this.#robots.length;
    this.#rows = sorted(matching(this.#robots.map(rowOf), this.#search.value), this.#key, this.#falls);
    say(byId("fleet-count"), this.#rows.length === all ? plural(all, "robot") : `${this.#rows.length} of ${plural(all, "robot")}`);
    this.#draw();
  }

  /** Draw the rows in view. */
  #draw() {
    const rows = this.#rows;
    const { from, to } = windowOf(this.#scroller.scrollTop, this.#scroller.clientHeight, ROW, rows.length);
    this.#above.style.height = `${from * ROW}px`;
    this.#below.style.height = `${(rows.length - to) * ROW}px`;
    this.#table.setAttribute("aria-rowcount", String(rows.length + 1));
    const drawn = rows.slice(from, to).map((row, i) => ({ row, index: from + i + 2 }));
    show(this.#body, drawn, ({ row }) => row.id, ({ row }) => this.#create(row), fill);
    COLUMNS.forEach(([key], i) => this.#heads[i].setAttribute("aria-sort", key !== this.#key ? "none" : this.#falls ? "descending" : "ascending"));
  }

  #create({ id }) {
    const open = make("button", { type: "button", className: "link", textContent: id, onclick: () => this.#pick(id) });
    return make("tr", {}, make("th", { scope: "row" }, open), ...COLUMNS.slice(1).map(() => make("td")));
  }

  #pick(id) {
    this.#dialog.close();
    const robot = this.#robots.find((one) => one.id === id);
    if (robot) this.#picked(robot); // else it has been removed meanwhile
  }
}

function fill(element, { row, index }) {
  element.setAttribute("aria-rowindex", String(index));
  COLUMNS.slice(1).forEach(([key], i) => {
    const cell = element.children[i + 1];
    say(cell, row[key]);
    cell.title = row[key];
  });
  element.children[1].className = "presence";
  element.children[1].dataset.presence = PRESENCE[row.state] ?? row.state;
}
