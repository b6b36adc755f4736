/** The building of the shown map: polls what its lifts and doors do, and shows it on the map and in the panel. */

import { BuildingLayer } from "./building_layer.js";
import { BuildingPanel } from "./building_panel.js";
import { buildingOf, partsOn, pathOfBuilding } from "./building_state.js";
import { Refused } from "./rest.js";
import { readTheme } from "./theme.js";

const PERIOD = 1000; // ms between two looks
const SLOW = 10_000; // after the cloud had nothing to show
const LAYOUT = 15_000; // ms for which the places of lifts and doors are good

export class BuildingView {
  layer = new BuildingLayer(readTheme());
  #panel = new BuildingPanel();
  #rest;
  #cloud;
  #events;
  /** What is polled now; another one ends the polls of the one before. @type {{path: string, floor: string, name: string} | null} */ #polled = null;
  #layout = { path: "", version: 0, read: -Infinity, found: null };
  #timer = 0;

  /**
   * @param {import("./rest.js").Rest} rest @param {import("./cloud_state.js").CloudState} cloud
   * @param {{changed: () => void, failed: (error: Error) => void}} events
   */
  constructor(rest, cloud, events) {
    this.#rest = rest;
    this.#cloud = cloud;
    this.#events = events;
  }

  /** Show the building of a map, if it has one. @param {string | null} map */
  follow(map) {
    const { buildings, me } = this.#cloud;
    const building = buildingOf(buildings, map, me.id);
    const path = building && pathOfBuilding(building, me.id);
    const floor = building?.floors[building.maps.indexOf(map)] ?? "";
    if (path === (this.#polled?.path ?? null) && floor === (this.#polled?.floor ?? "")) return;
    clearTimeout(this.#timer);
    this.#polled = building ? { path, floor, name: building.id } : null;
    this.#show(null);
    if (building) this.#look(this.#polled);
  }

  async #look(polled) {
    let period = PERIOD;
    try {
      const state = document.visibilityState === "visible" ? await this.#rest.get(`${polled.path}/state`) : null;
      if (state) await this.#readLayout(polled.path, state.building);
      if (polled !== this.#polled) return;
      if (state) this.#show(state);
      if (state && !state.lifts.length && !state.doors.length) period = SLOW;
    } catch (error) {
      if (polled !== this.#polled) return;
      if (error instanceof Refused && error.status !== 401) this.#show(null);
      else this.#events.failed(error);
      period = SLOW;
    }
    this.#timer = setTimeout(() => this.#look(polled), period);
  }

  /** Where lifts and doors are changes with the building and with the zones of its maps. */
  async #readLayout(path, version) {
    const { path: before, version: known, read } = this.#layout;
    if (path === before && version === known && performance.now() - read < LAYOUT) return;
    this.#layout = { path, version, read: performance.now(), found: await this.#rest.get(`${path}/layout`) };
  }

  #show(state) {
    this.layer.parts = state ? partsOn(this.#layout.found, state, this.#polled.floor) : [];
    this.#panel.update(state, this.#polled?.name ?? "", this.#cloud.now);
    this.#events.changed();
  }
}
