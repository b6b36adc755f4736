import assert from "node:assert/strict";
import test from "node:test";

import {
  buildingOf, doorText, journeyText, liftText, noteOf, partsOn, pathOfBuilding,
} from "../../../../endpoints/dashboard/static/js/building_state.js";

const CAR = [[0, 0], [2, 0], [2, 2], [0, 2]];
const LAYOUT = {
  lifts: { north: [{ floor: "L1", outline: CAR }, { floor: "L2", outline: CAR }], dead: [{ floor: "L1", outline: CAR }] },
  doors: [
    { floor: "L1", door: "landing", ends: [[0, 2], [2, 2]], lift: "north" },
    { floor: "L1", door: "gate", ends: [[5, 0], [6, 0]], lift: "" },
    { floor: "L1", door: "plain", ends: [[7, 0], [8, 0]], lift: "" },
    { floor: "L2", door: "landing", ends: [[0, 2], [2, 2]], lift: "north" },
  ],
};
const LIFT = { lift: "north", fault: "", floor: "L1", target: "", door: "open", motion: "stopped", mode: "agv", rides: [] };
const GATE = { floor: "L1", door: "gate", mode: "moving", fault: "", robots: ["tb1", null] };

function state(lift = {}, door = {}) {
  return { building: 1, lifts: [{ ...LIFT, ...lift }], doors: [{ ...GATE, ...door }], faults: [], journeys: [] };
}

test("the building of a map is the user's own one, or another's", () => {
  const inns = [{ id: "inn", owner: "bob", maps: ["m1"] }, { id: "hut", owner: "ann", maps: ["m1", "m2"] }];
  assert.equal(buildingOf(inns, "m1", "ann").id, "hut");
  assert.equal(buildingOf(inns, "m1", "carol").id, "inn");
  assert.equal(buildingOf(inns, null, "ann"), null);
  assert.equal(pathOfBuilding(inns[0], "ann"), "v1/buildings/bob%3Ainn");
  assert.equal(pathOfBuilding(inns[1], "ann"), "v1/buildings/hut");
});

test("a car is drawn where it is, with its door, and elsewhere where it is not; only parts with a device are drawn", () => {
  const here = partsOn(LAYOUT, state(), "L1");
  assert.deepEqual(here.map(({ kind, name, look, words }) => [kind, name, look, words]), [
    ["lift", "north", "open", "here"], ["door", "landing", "open", ""], ["door", "gate", "moving", ""],
  ]);
  const above = partsOn(LAYOUT, state({ target: "L2", door: "closed" }), "L2");
  assert.deepEqual(above.map(({ look, words }) => [look, words]), [["elsewhere", "L1 → L2"], ["closed", ""]]);
});

test("who waits at a floor and what is wrong is written there", () => {
  const rides = [{ robot: "tb1", origin: "L2", destination: "L1", phase: "waiting" }];
  assert.equal(partsOn(LAYOUT, state({ rides }), "L2")[0].words, "at L1, 1 waits");
  assert.equal(partsOn(LAYOUT, state({ rides }), "L1")[0].words, "here");
  const [car, landing, gate] = partsOn(LAYOUT, state({ fault: "lift 'north' is in the mode 'fire'", mode: "fire" }, { fault: "jammed" }), "L1");
  assert.deepEqual([car.look, car.words, landing.look, gate.look, gate.words], ["fault", "fire", "fault", "fault", "fault"]);
  assert.equal(partsOn(LAYOUT, state({ fault: "lift 'north' reports nothing", mode: "unknown", floor: "" }), "L1")[0].look, "unknown");
});

test("lifts, doors and journeys are told in words", () => {
  assert.equal(liftText(LIFT), "At L1, doors open");
  const rides = [{ robot: "tb1", origin: "L1", destination: "L2", phase: "inside" }, { robot: null, origin: "L2", destination: "L1", phase: "waiting" }];
  assert.equal(
    liftText({ ...LIFT, motion: "up", target: "L2", rides }),
    "Drives up from L1, sent to L2; tb1 rides to L2; another user's robot waits at L2 to ride to L1",
  );
  assert.equal(liftText({ ...LIFT, fault: "lift 'north' reports nothing" }), "lift 'north' reports nothing");
  assert.equal(doorText(GATE), "Moves, held for tb1, another user's robot");
  assert.equal(doorText({ ...GATE, mode: "closed", robots: [] }), "Closed");
  assert.equal(doorText({ ...GATE, fault: "door 'gate' is offline" }), "door 'gate' is offline");
  const journey = { on: "L1", floor: "L2", phase: "waiting", leg: "north", state: "active", text: "lift is called", since: 100, ended: null };
  assert.equal(journeyText(journey, 130), "waits for north on L1, to L2, for 30 s: lift is called");
  assert.equal(journeyText({ ...journey, phase: "driving", leg: "", text: "" }, 100), "drives on L1, to L2, for 0 s");
  assert.equal(journeyText({ ...journey, on: "L2", state: "succeeded", text: "", ended: 190 }, 500), "has arrived on L2 after 1 min");
});

test("the note counts faults, and names devices that cannot be used", () => {
  assert.equal(noteOf(state()), "");
  assert.equal(noteOf(state({ fault: "fire", mode: "fire" })), "1 of the lifts and doors has a fault");
  assert.equal(noteOf({ ...state({ fault: "fire", mode: "fire" }, { fault: "jammed" }), faults: ["lift 'x': no plug-in"] }), "2 of the lifts and doors have a fault. lift 'x': no plug-in");
  assert.equal(noteOf(state({ fault: "silent", mode: "unknown" })), "");
});
