/** Panel of the building of the shown map: its lifts and doors that have devices, and the journeys over its floors. */

import { doorText, journeyText, liftText, noteOf } from "./building_state.js";
import { byId, make, say, show } from "./dom.js";

const SHOWN = { elsewhere: "online", open: "online", closed: "online", moving: "online" };

export class BuildingPanel {
  #panel = byId("panel-building");

  /** @param {import("./building_state.js").State | null} state @param {string} name of the building @param {number} now [s since the epoch] */
  update(state, name, now) {
    this.#panel.hidden = !state || !(state.lifts.length || state.doors.length || state.journeys.length || state.faults.length);
    if (this.#panel.hidden) return;
    say(byId("building-name"), name);
    say(byId("building-note"), noteOf(state));
    const parts = [
      ...state.lifts.map((lift) => ({ key: `lift ${lift.lift}`, title: `Lift ${lift.lift}`, standing: standingOf(lift, lift.floor || "unknown"), text: liftText(lift) })),
      ...state.doors.map((door) => ({ key: `door ${door.floor} ${door.door}`, title: `Door ${door.door} on ${door.floor}`, standing: standingOf(door, door.mode), text: doorText(door) })),
    ];
    show(byId("building-parts"), parts, ({ key }) => key, create, fill);
    const journeys = state.journeys.map((journey, i) => ({
      key: journey.goal ?? `${i} ${journey.since}`, title: journey.robot ?? "Another user's robot",
      standing: [journey.state === "active" ? "online" : journey.state === "failed" ? "lost" : "offline", journey.state === "active" ? "under way" : "ended"],
      text: journeyText(journey, now),
    }));
    show(byId("building-journeys"), journeys.toReversed(), ({ key }) => key, create, fill);
    byId("building-journeys-title").hidden = !journeys.length;
  }
}

/** How a lift or a door is: what the dot beside its name shows, and the word for it. */
function standingOf({ fault, mode }, word) {
  if (!fault) return [SHOWN[word] ?? "online", word];
  return mode === "unknown" ? ["silent", "silent"] : ["lost", "fault"];
}

function create({ title }) {
  return make("li", { className: "building-part" }, make("span", { className: "name", textContent: title, title }), make("span", { className: "presence" }), make("span", { className: "muted" }));
}

function fill(item, { standing: [look, word], text }) {
  const [, presence, what] = item.children;
  presence.dataset.presence = look;
  say(presence, word);
  say(what, text);
}
