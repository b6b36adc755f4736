/** Page with buildings: the record of one, with its floors and the settings of its lifts, doors and ways; make one, change it. */

import { buildingOf, pathOfBuilding } from "../building_state.js";
import { make, say, show } from "../dom.js";
import { NAME_OF_MAP } from "../order_form.js";
import { addPage } from "../registry.js";
import { Refused } from "../rest.js";
import { BuildingForm } from "./building_form.js";
import { aboutText, foundText, mayEdit } from "./building_words.js";

const NEW = "";

class BuildingsPage {
  #context;
  #choice = make("select", { name: "building" });
  #name = make("input", { name: "id", placeholder: "hotel", ...NAME_OF_MAP });
  #nameLabel = make("label", {}, "Id of the new building", this.#name);
  #reason = make("input", { name: "message", maxLength: 200, placeholder: "As measured in May" });
  #about = make("p", { className: "muted", role: "status" });
  #problem = make("p", { className: "error", role: "alert" });
  #warnings = make("ul", { className: "muted", "aria-label": "What may be wrong" });
  #body = make("div", { className: "page-parts" });
  #check = button("Check", () => this.#judge());
  #save = button("Save", () => this.#put(), "button primary");
  #reload = button("Discard", () => this.#open(this.#address));
  #remove = button("Remove building", () => this.#drop(), "button stop");
  #actions = make("div", { className: "actions" }, this.#check, this.#save, this.#reload, this.#remove);
  /** @type {BuildingForm | null} */ #form = null;
  /** The building that is shown, as it was read; null for a new one. @type {object | null} */ #read = null;
  #address = NEW;
  #isChanged = false;
  /** Whether the cloud has said which buildings there are, and whether one was opened. */
  #isKnown = false;
  #isBegun = false;
  element = make("div", { className: "page-parts buildings" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#choice.addEventListener("change", () => this.#choose());
    const why = make("label", {}, "Why", this.#reason);
    const head = make("div", { className: "fields" }, make("label", {}, "Building", this.#choice), this.#nameLabel, why);
    this.element.append(head, this.#about, this.#body, this.#problem, this.#warnings, this.#actions);
  }

  update() {
    this.#isKnown = true;
    const { buildings, me } = this.#context.cloud;
    const known = buildings.map((building) => ({ address: building.owner === me.id ? building.id : `${building.owner}:${building.id}` }));
    show(this.#choice, [...known, { address: NEW }], ({ address }) => `at ${address}`, ({ address }) => make("option", { value: address, textContent: address || "New building" }), () => {});
    this.#choice.value = this.#address;
    this.#showActions();
  }

  /** Show the building of the shown map, or the first one, once the page is opened. */
  async poll() {
    if (this.#isBegun || !this.#isKnown) return;
    const { buildings, map, me } = this.#context.cloud;
    const first = buildingOf(buildings, map, me.id) ?? buildings[0];
    this.#isBegun = true;
    await this.#open(first ? (first.owner === me.id ? first.id : `${first.owner}:${first.id}`) : NEW);
  }

  #choose() {
    const wanted = this.#choice.value;
    if (this.#isChanged && !confirm("Forget what you have changed?")) this.#choice.value = this.#address;
    else this.#open(wanted);
  }

  /** @param {string} address */
  async #open(address) {
    const { rest, cloud, failed } = this.#context;
    try {
      this.#read = address === NEW ? null : await rest.get(`v1/buildings/${encodeURIComponent(address)}`);
    } catch (error) {
      failed(error);
      return;
    }
    this.#address = address;
    this.#isChanged = false;
    this.#say("");
    const maps = cloud.maps.map(({ id }) => id);
    this.#form = new BuildingForm(this.#read?.building ?? { floors: [{}] }, maps, this.#mayEdit, () => this.#edit());
    this.#body.replaceChildren(this.#form.element);
    this.#reason.value = "";
    this.update();
  }

  get #mayEdit() {
    return !this.#read || mayEdit(this.#read, this.#context.cloud.me);
  }

  /** The version that others have made meanwhile; null if there is none. */
  get #newer() {
    const found = this.#read && this.#context.cloud.buildings.find(({ owner, id }) => owner === this.#read.owner && id === this.#read.id);
    return found && found.version > this.#read.version ? found : null;
  }

  get #path() {
    const { me } = this.#context.cloud;
    return this.#read ? pathOfBuilding(this.#read, me.id) : `v1/buildings/${encodeURIComponent(this.#name.value.trim())}`;
  }

  #edit() {
    this.#isChanged = true;
    this.#showActions();
  }

  #say(problem, warnings = []) {
    say(this.#problem, problem);
    this.#warnings.replaceChildren(...warnings.map((textContent) => make("li", { textContent })));
  }

  #showActions() {
    const newer = this.#newer;
    this.#nameLabel.hidden = Boolean(this.#read);
    this.#remove.hidden = !this.#read;
    this.#actions.hidden = !this.#mayEdit;
    this.#save.disabled = !this.#isChanged || Boolean(newer);
    say(this.#reload, newer ? "Reload" : "Discard");
    this.#reload.hidden = !this.#isChanged && !newer;
    const about = this.#read ? aboutText(this.#read, this.#context.cloud.me.id) : "Name a floor for each map; its lifts, doors and ways are zones of the maps.";
    say(this.#about, newer ? `${newer.author} has made version ${newer.version} meanwhile: reload it, and make your changes again.` : about);
  }

  /** The record that the form says; null if a field is not valid. */
  #said() {
    if (!this.#form.element.reportValidity() || (!this.#read && !this.#name.reportValidity())) return null;
    try {
      return this.#form.building;
    } catch (error) {
      this.#say(error.message);
      return null;
    }
  }

  async #judge() {
    const record = this.#said();
    if (!record) return;
    await this.#try(async () => {
      const found = await this.#context.rest.post(`${this.#path}/check`, record);
      this.#say("", [foundText(found), ...found.warnings]);
    });
  }

  async #put() {
    const record = this.#said();
    if (!record) return;
    const { rest, ask, cloud } = this.#context;
    const reason = this.#reason.value ? `?message=${encodeURIComponent(this.#reason.value)}` : "";
    const tag = this.#read && `"${this.#read.version}"`;
    await this.#try(async () => {
      const made = await rest.put(`${this.#path}${reason}`, record, tag, "application/json");
      cloud.forgetBuildings();
      await ask(Promise.resolve(), `${made.id} is saved as version ${made.version}`);
      await this.#open(made.owner === cloud.me.id ? made.id : `${made.owner}:${made.id}`);
      this.#say("", made.warnings);
    });
  }

  #drop() {
    if (!confirm(`Remove ${this.#address} with all its versions? Its maps stay.`)) return;
    this.#try(async () => {
      const { rest, ask, cloud } = this.#context;
      await rest.delete(this.#path);
      cloud.forgetBuildings();
      await ask(Promise.resolve(), `${this.#address} is removed`);
      await this.#open(NEW);
    });
  }

  /** Do what the user wants; the page says why it is refused. @param {() => Promise<void>} order */
  async #try(order) {
    this.#save.disabled = this.#check.disabled = true;
    this.#say("");
    try {
      await order();
    } catch (error) {
      this.#say(error.message);
      if (error instanceof Refused && error.status === 409) this.#context.cloud.forgetBuildings(); // the next look finds the newer version
    } finally {
      this.#check.disabled = false;
      this.#showActions();
    }
  }
}

function button(textContent, onclick, className = "button") {
  return make("button", { className, type: "button", textContent, onclick });
}

addPage({ id: "buildings", title: "Buildings", order: 2.7, create: (context) => new BuildingsPage(context) });
