/** Switch of floors: buttons for the maps of the building of the shown map. */

import { byId, make, show } from "./dom.js";

/**
 * The floors of the buildings that have a map, the highest first; none if no building has it.
 * @param {{floors: string[], maps: string[], elevations: number[]}[]} buildings @param {string | null} map @param {Set<string>} known maps that the user may see
 * @returns {{name: string, map: string, isShown: boolean, isKnown: boolean}[]}
 */
export function floorsOf(buildings, map, known) {
  const building = buildings.find(({ maps }) => maps.includes(map));
  if (!building) return [];
  const floors = building.floors.map((name, i) => ({ name, map: building.maps[i], height: building.elevations[i], isShown: building.maps[i] === map, isKnown: known.has(building.maps[i]) }));
  return floors.sort((a, b) => b.height - a.height).map(({ height: _height, ...floor }) => floor);
}

export class FloorSwitch {
  #group = byId("floors");
  #chosen;

  /** @param {(map: string) => void} chosen */
  constructor(chosen) {
    this.#group.replaceChildren();
    this.#chosen = chosen;
  }

  /** @param {object[]} buildings @param {string | null} map @param {{id: string}[]} maps */
  update(buildings, map, maps) {
    const floors = floorsOf(buildings, map, new Set(maps.map(({ id }) => id)));
    this.#group.hidden = floors.length < 2;
    show(this.#group, this.#group.hidden ? [] : floors, ({ map: id }) => id, (floor) => this.#create(floor), (button, { name, isShown, isKnown }) => {
      if (button.textContent !== name) button.textContent = name;
      button.setAttribute("aria-pressed", String(isShown));
      button.disabled = !isKnown;
    });
  }

  #create({ map }) {
    return make("button", { className: "tool", type: "button", onclick: () => this.#chosen(map) });
  }
}
