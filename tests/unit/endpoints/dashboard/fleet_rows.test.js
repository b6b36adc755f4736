import assert from "node:assert/strict";
import { test } from "node:test";

const { matching, rowOf, sorted, windowOf } = await import("../../../../endpoints/dashboard/static/js/fleet_rows.js");

const ROBOT = { id: "tb1", map: "house" };
const link = (presence, seenAt, goal = null) => ({ presence, seenAt, waits: false, connected: true, held: "", state: { exploration: null, goal, remaining: null } });
const named = (...names) => names.map((id) => ({ ...rowOf({ ...ROBOT, id }, undefined, null, 0), id }));

test("a row has what the page knows of a robot", () => {
  const container = { connected: true, state: "ready", machine: "m1" };
  const driving = rowOf(ROBOT, container, link("online", 9, { code: 1, active: true, text: "" }), 10);
  assert.deepEqual([driving.state, driving.task, driving.error, driving.seen, driving.machine], ["online", "Driving", "", "now", "m1"]);
  const failed = rowOf(ROBOT, container, link("silent", 0, { code: 4, active: false, text: "no way", word: "gave up" }), 90);
  assert.deepEqual([failed.state, failed.task, failed.error, failed.seen], ["no signal", "", "no way", "1 min ago"]);
  assert.equal(rowOf(ROBOT, container, link("online", 0, { code: 9, active: false, text: "", word: "lost" }), 1).error, "lost");
});

test("a robot of another map is known by its container alone", () => {
  const state = (container) => rowOf(ROBOT, container, null, 10).state;
  assert.equal(state({ connected: true, state: "ready" }), "online");
  assert.equal(state({ connected: true, state: "starting" }), "starting");
  assert.equal(state({ connected: false, state: "ready" }), "offline");
  assert.deepEqual([state(undefined), rowOf(ROBOT, undefined, null, 10).seen], ["offline", "–"]);
});

test("all words of a search are to be found, in any column and case", () => {
  const rows = [rowOf({ id: "tb1", map: "House" }, { machine: "m1" }, null, 0), rowOf({ id: "tb2", map: "attic" }, { machine: "m1" }, null, 0)];
  const found = (text) => matching(rows, text).map(({ id }) => id);
  assert.deepEqual([found(""), found(" m1 house"), found("TB2 house"), found("offline")], [["tb1", "tb2"], ["tb1"], [], ["tb1", "tb2"]]);
});

test("rows are sorted by numbers in names, with empty fields last in both directions", () => {
  const ids = (rows, ...by) => sorted(rows, ...by).map(({ id }) => id);
  assert.deepEqual(ids(named("tb10", "tb9"), "id", false), ["tb9", "tb10"]);
  assert.deepEqual(ids(named("tb9", "tb10"), "id", true), ["tb10", "tb9"]);
  const [a, b, c] = named("a", "b", "c");
  const errors = [a, { ...b, error: "x" }, { ...c, error: "y" }];
  assert.deepEqual([ids(errors, "error", false), ids(errors, "error", true)], [["b", "c", "a"], ["c", "b", "a"]]);
  const ages = [a, { ...b, age: 3 }, { ...c, age: 0 }];
  assert.deepEqual([ids(ages, "seen", false), ids(ages, "seen", true)], [["c", "b", "a"], ["a", "b", "c"]]);
});

test("only the rows in view and some beside them are drawn", () => {
  assert.deepEqual(windowOf(0, 440, 44, 500), { from: 0, to: 18 });
  assert.deepEqual(windowOf(4400, 440, 44, 500), { from: 92, to: 118 });
  assert.deepEqual(windowOf(99_999, 440, 44, 5), { from: 0, to: 5 });
  assert.deepEqual(windowOf(0, 440, 44, 0), { from: 0, to: 0 });
});
