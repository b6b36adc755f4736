import assert from "node:assert/strict";
import test from "node:test";

import { ZonesState, kindsOf, told, valueOf } from "../../../../endpoints/dashboard/static/js/zones_state.js";

const SQUARE = [[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]];
const zone = (name, properties = {}, geometry = { type: "Polygon", coordinates: [SQUARE] }) => ({ type: "Feature", geometry, properties: { name, kind: "keep_out", ...properties } });
const answerOf = (features, inForce) => ({ type: "FeatureCollection", features, time_zone: "Europe/Berlin", ...(inForce && { in_force: inForce }) });

function stateOf(...features) {
  const state = new ZonesState();
  state.take(answerOf(features, ["a"]), '"1"');
  return state;
}

test("a zone is told in words, with its value and its hours", () => {
  assert.equal(told(zone("a")), "Keep out");
  assert.equal(told(zone("a", { kind: "speed_limit", max_speed: 0.3 })), "Speed limit 0.3 m/s");
  assert.equal(told(zone("a", { kind: "speed_limit", percent: 50 })), "Speed limit 50 %");
  assert.equal(told(zone("a", { kind: "capacity", robots: 2 })), "Capacity 2 robots");
  assert.equal(told(zone("a", { kind: "capacity", robots: 1 })), "Capacity 1 robot");
  assert.equal(told(zone("a", { kind: "one_way", direction: Math.PI / 2, strict: true })), "One way 90°, strict");
  assert.equal(told(zone("a", { kind: "one_way", width: 1.5 })), "One way 1.5 m wide");
  assert.equal(told(zone("a", { kind: "lane" })), "Lane");
  assert.equal(told(zone("a", { kind: "lane", one_way: true })), "Lane, one way");
  assert.equal(told(zone("a", { kind: "no_stop", times: [{ days: ["mon", "tue"], from: "08:00" }, {}] })), "No stopping; mon, tue 08:00 to 24:00; always");
  assert.equal(told(zone("a", { times: [{ since: "2026-12-24T08:00:00Z", until: "2026-12-27T00:00:00Z" }] })), "Keep out; since 2026-12-24 08:00:00Z until 2026-12-27 00:00:00Z");
  const weekdays = [{ days: ["mon", "tue", "wed", "thu", "fri"] }, { days: ["mon", "wed", "fri"], to: "12:00" }];
  assert.equal(told(zone("a", { times: weekdays })), "Keep out; mon to fri; mon, wed, fri 00:00 to 12:00");
  assert.equal(told(zone("a", { kind: "new_kind" })), "new_kind");
});

test("the value of a zone is told without its kind", () => {
  assert.equal(valueOf({ kind: "one_way", direction: Math.PI, strict: true }), "180°, strict");
  assert.equal(valueOf({ kind: "lane", one_way: true }), "one way");
  assert.equal(valueOf({ kind: "lane" }), "");
  assert.equal(valueOf({ kind: "new_kind" }), "");
});

test("lines are lanes, doors or lead one way, points are places, and areas all else", () => {
  for (const type of ["LineString", "MultiLineString"]) assert.deepEqual(kindsOf({ type, coordinates: [[[0, 0], [1, 0]]] }), ["lane", "one_way", "door"]);
  assert.deepEqual(kindsOf({ type: "Point", coordinates: [0, 0] }), ["station", "passage", "dock"]);
  assert.deepEqual(kindsOf({ type: "Polygon", coordinates: [SQUARE] }), ["keep_out", "speed_limit", "one_way", "no_stop", "capacity", "lift"]);
});

test("places of a building are told with what they belong to", () => {
  assert.equal(valueOf({ kind: "door", lift: "north" }), "of lift north");
  assert.equal(valueOf({ kind: "passage", way: "ramp", yaw: 1 }), "ramp");
  assert.equal(valueOf({ kind: "dock", yaw: 0, dock_type: "v_shape", charges: false }), "v_shape, no charger");
  assert.equal(valueOf({ kind: "dock", yaw: 0 }), "");
});

test("new places of a building are ones that the cloud takes", () => {
  const state = stateOf();
  const properties = (kind) => state.proposal(kind, { type: "Point", coordinates: [0, 0] }).properties;
  assert.deepEqual(properties("dock"), { name: "Dock 1", kind: "dock", yaw: 0 });
  assert.deepEqual(properties("passage"), { name: "Way 1", kind: "passage", way: "ramp", yaw: 0 });
  assert.deepEqual(properties("door"), { name: "Door 1", kind: "door" });
});

test("the cloud says which zones are in force", () => {
  const state = stateOf(zone("a"), zone("b"));
  assert.deepEqual([state.standing(0), state.standing(1)], ["in force", "not in force"]);
  state.take(answerOf([zone("a"), zone("b")]), '"1"');
  assert.equal(state.standing(1), "in force");
});

test("changes are a draft until they are saved or discarded", () => {
  const state = stateOf(zone("a"), zone("b"));
  assert.equal(state.isChanged, false);
  state.replace(0, zone("a"));
  assert.equal(state.isChanged, false, "a change to the same is none");
  state.replace(0, zone("c"));
  state.add(zone("d"));
  assert.equal(state.picked, 2);
  state.remove(1);
  assert.deepEqual(state.features.map(({ properties }) => properties.name), ["c", "d"]);
  assert.deepEqual([state.standing(0), state.standing(1), state.picked], ["not saved", "not saved", null]);
  assert.deepEqual(state.body, { type: "FeatureCollection", features: state.features, time_zone: "Europe/Berlin" });
  state.discard();
  assert.deepEqual(state.features.map(({ properties }) => properties.name), ["a", "b"]);
  assert.equal(state.isChanged, false);
});

test("zones of a draft that were not changed stay saved while the cloud is asked", () => {
  const state = stateOf(zone("a"), zone("b"));
  state.replace(1, zone("c"));
  state.take(answerOf([zone("a"), zone("b")], []), '"1"');
  assert.deepEqual([state.standing(0), state.standing(1)], ["not in force", "not saved"]);
  assert.equal(state.isOutdated, false);
});

test("a draft is outdated once somebody else has changed the zones", () => {
  const state = stateOf(zone("a"));
  state.setTimeZone("UTC");
  assert.equal(state.body.time_zone, "UTC");
  state.take(answerOf([zone("a")], []), '"1b"');
  assert.deepEqual([state.isOutdated, state.base], [false, '"1b"'], "the same zones with another tag");
  state.take(answerOf([zone("z")]), '"2"');
  assert.deepEqual([state.isOutdated, state.base], [true, '"1b"']);
  assert.equal(state.features[0].properties.name, "a", "what the user has made stays");
  state.discard();
  assert.equal(state.features[0].properties.name, "z");
});

test("what is picked stays while the zones are the same", () => {
  const state = stateOf(zone("a"), zone("b", {}, { type: "LineString", coordinates: [[5, 5], [9, 5]] }));
  state.picked = state.at({ x: 1, y: 1 }, 0.2);
  assert.equal(state.picked, 0);
  assert.equal(state.at({ x: 7, y: 5.1 }, 0.2), 1);
  assert.equal(state.at({ x: 7, y: 8 }, 0.2), null);
  const before = state.generation;
  state.take(answerOf([zone("a"), state.features[1]], ["b"]), '"1"');
  assert.deepEqual([state.picked, state.generation], [0, before]);
  state.take(answerOf([zone("x")]), '"2"');
  assert.equal(state.picked, null);
  assert.notEqual(state.generation, before);
});

test("a map without zones to ask for shows none", () => {
  const state = stateOf(zone("a"));
  state.take(null, null);
  assert.deepEqual([state.features, state.answer], [[], null]);
  state.clear();
  assert.deepEqual([state.features, state.timeZone], [[], "UTC"]);
});

test("new zones have a name of their own and usual values", () => {
  const state = stateOf(zone("Keep out 1"));
  const area = { type: "Polygon", coordinates: [SQUARE] };
  const line = { type: "LineString", coordinates: [[0, 0], [0, 3]] };
  assert.deepEqual(state.proposal("keep_out", area).properties, { name: "Keep out 2", kind: "keep_out" });
  assert.deepEqual(state.proposal("speed_limit", area).properties, { name: "Speed limit 1", kind: "speed_limit", max_speed: 0.5 });
  assert.deepEqual(state.proposal("capacity", area).properties, { name: "Capacity 1", kind: "capacity", robots: 1 });
  assert.deepEqual(state.proposal("one_way", line).properties, { name: "One way 1", kind: "one_way", width: 1 });
  assert.deepEqual(state.proposal("lane", line).properties, { name: "Lane 1", kind: "lane" });
  const turned = { type: "Polygon", coordinates: [[[0, 0], [0, 3], [3, 3], [0, 0]]] };
  assert.equal(state.proposal("one_way", turned).properties.direction, 1.571);
});

test("zones name their time zone only where it is not that of all", () => {
  const state = stateOf(zone("a", { times: [{}], time_zone: "Europe/Berlin" }), zone("b", { times: [{}], time_zone: "Asia/Tokyo" }));
  assert.deepEqual(state.features.map(({ properties }) => properties.time_zone), [undefined, "Asia/Tokyo"]);
  assert.equal(told(state.features[1]), "Keep out; always; Asia/Tokyo");
});

test("what the cloud says on a draft is forgotten with the next change", () => {
  const state = stateOf(zone("a"));
  state.replace(0, zone("b"));
  state.judge({ problem: "it crosses itself", faults: [{ zone: "b", text: "it crosses itself", place: [1, 1] }] });
  assert.deepEqual([state.problem, state.faults.length], ["it crosses itself", 1]);
  state.replace(0, zone("c"));
  assert.deepEqual([state.problem, state.faults, state.warnings], ["", [], []]);
});

test("outlines are sent counterclockwise, and holes clockwise", () => {
  const clockwise = SQUARE.toReversed();
  const state = stateOf(zone("a", {}, { type: "Polygon", coordinates: [clockwise, SQUARE] }), zone("b", {}, { type: "MultiPolygon", coordinates: [[clockwise]] }));
  state.setTimeZone("UTC");
  assert.deepEqual(state.body.features.map(({ geometry }) => geometry.coordinates), [[SQUARE, clockwise], [[SQUARE]]]);
  assert.deepEqual(state.features[0].geometry.coordinates, [clockwise, SQUARE], "what is shown stays as it was drawn");
});
