/**
 * Lifts and doors of a building on one of its floors: where they are, and what they do, in words.
 *
 * @typedef {{robot: string | null, origin: string, destination: string, phase: string}} Ride
 * @typedef {{lift: string, fault: string, floor: string, target: string, door: string, motion: string, mode: string, rides: Ride[]}} Lift
 * @typedef {{floor: string, door: string, mode: string, fault: string, robots: (string | null)[]}} Door
 * @typedef {{robot: string | null, goal: string | null, on: string, floor: string, phase: string, leg: string, state: string,
 *            text: string, since: number, ended: number | null}} Journey
 * @typedef {{building: number, lifts: Lift[], doors: Door[], faults: string[], journeys: Journey[]}} State
 * @typedef {{kind: "lift" | "door", name: string, look: "open" | "closed" | "moving" | "elsewhere" | "fault" | "unknown",
 *            words: string, outline: number[][]}} Part a closed outline of a car, or the two ends of a door
 */

import { duration } from "./format.js";

const OTHERS = "another user's robot";
const PHASES = { planning: "is planned", driving: "drives", waiting: "waits", boarding: "boards", inside: "rides", alighting: "leaves the car", crossing: "crosses" };
const ENDS = { succeeded: "has arrived", failed: "has failed", canceled: "was cancelled" };

/** The building whose floor a map is, the user's own one first; null if there is none. @param {{owner: string, maps: string[]}[]} buildings @param {string | null} map @param {string} me */
export function buildingOf(buildings, map, me) {
  const having = buildings.filter(({ maps }) => maps.includes(map));
  return having.find(({ owner }) => owner === me) ?? having[0] ?? null;
}

/** The path of a building. @param {{owner: string, id: string}} building @param {string} me */
export function pathOfBuilding({ owner, id }, me) {
  return `v1/buildings/${encodeURIComponent(owner === me ? id : `${owner}:${id}`)}`;
}

/** What is to be drawn on a floor. @param {{lifts: Record<string, object[]>, doors: object[]}} layout @param {State} state @param {string} floor @returns {Part[]} */
export function partsOn(layout, state, floor) {
  const lifts = new Map(state.lifts.map((lift) => [lift.lift, lift]));
  const doors = new Map(state.doors.map((door) => [`${door.floor}/${door.door}`, door]));
  const parts = [];
  for (const [name, landings] of Object.entries(layout.lifts)) {
    const lift = lifts.get(name);
    for (const { outline } of lift ? landings.filter((landing) => landing.floor === floor) : []) parts.push({ kind: "lift", name, look: lookOfLift(lift, floor), words: wordsHere(lift, floor), outline });
  }
  for (const { floor: on, door: name, ends, lift: behind } of layout.doors.filter((door) => door.floor === floor)) {
    const lift = lifts.get(behind);
    const door = doors.get(`${on}/${name}`);
    if (lift) parts.push({ kind: "door", name, look: lookOfLift(lift, floor) === "open" ? "open" : lift.fault ? "fault" : "closed", words: "", outline: ends });
    else if (door) parts.push({ kind: "door", name, look: door.fault ? "fault" : door.mode, words: door.fault ? "fault" : "", outline: ends });
  }
  return parts;
}

function lookOfLift({ fault, floor: at, door, mode }, floor) {
  if (fault && mode === "unknown") return "unknown";
  if (fault) return "fault";
  return at === floor ? door : "elsewhere";
}

/** What a lift does, seen from a floor. */
function wordsHere({ fault, floor: at, target, mode, rides }, floor) {
  if (fault) return mode === "agv" || mode === "human" ? "in use" : mode === "unknown" ? "silent" : mode;
  const waiting = rides.filter(({ phase, origin }) => phase === "waiting" && origin === floor).length;
  const where = at === floor ? "here" : at ? `at ${at}` : "";
  const parts = [target && target !== at ? `${at || "?"} → ${target}` : where, waiting && `${waiting} ${waiting === 1 ? "waits" : "wait"}`];
  return parts.filter(Boolean).join(", ");
}

/** A lift in words. @param {Lift} lift */
export function liftText({ fault, floor, target, door, motion, rides }) {
  if (fault) return [fault, ...rides.map(rideText)].join("; ");
  const where = motion === "stopped" ? `At ${floor || "an unknown floor"}, doors ${door}` : `Drives ${motion} from ${floor || "an unknown floor"}`;
  const parts = [target && target !== floor ? `${where}, sent to ${target}` : where, ...rides.map(rideText)];
  return parts.join("; ");
}

function rideText({ robot, origin, destination, phase }) {
  const who = robot ?? OTHERS;
  if (phase === "waiting") return `${who} waits at ${origin} to ride to ${destination}`;
  return `${who} ${PHASES[phase]} to ${destination}`;
}

/** A door in words. @param {Door} door */
export function doorText({ fault, mode, robots }) {
  if (fault) return fault;
  const held = robots.length ? `, held for ${robots.map((robot) => robot ?? OTHERS).join(", ")}` : "";
  return `${mode === "moving" ? "Moves" : mode === "open" ? "Open" : "Closed"}${held}`;
}

/** A journey in words. @param {Journey} journey @param {number} now [s since the epoch] */
export function journeyText({ on, floor, phase, leg, state, text, since, ended }, now) {
  const why = text ? `: ${text}` : "";
  if (state !== "active") return `${ENDS[state]} on ${on} after ${duration(ended - since)}${why}`;
  const at = leg ? ` ${phase === "waiting" ? "for" : "by"} ${leg}` : "";
  return `${PHASES[phase]}${at} on ${on}, to ${floor}, for ${duration(now - since)}${why}`;
}

/** What is wrong in a building. @param {State} state @returns {string} */
export function noteOf({ lifts, doors, faults }) {
  const broken = lifts.filter(({ fault, mode }) => fault && mode !== "unknown").length + doors.filter(({ fault, mode }) => fault && mode !== "unknown").length;
  const parts = [broken && `${broken} of the lifts and doors ${broken === 1 ? "has" : "have"} a fault`, ...faults];
  return parts.filter(Boolean).join(". ");
}
