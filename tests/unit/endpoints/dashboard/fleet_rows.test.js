import assert from "node:assert/strict";
import { test } from "node:test";

const { matching, rowOf, sorted, windowOf } = await import("../../../../endpoints/dashboard/static/js/fleet_rows.js");

const ROBOT = { id: "tb1", map: "house", state: "online", battery: 0.8, seen_ago: 0, task: "Driving", error: "", machine: "m1", software: "acme 3.2" };
const row = (changes) => rowOf({ ...ROBOT, ...changes });

test("a row says in words what the cloud knows of a robot", () => {
  const known = row({});
  assert.deepEqual([known.state, known.battery, known.task, known.seen, known.machine, known.software], ["online", "80 %", "Driving", "now", "m1", "acme 3.2"]);
  assert.equal(row({ seen_ago: 90 }).seen, "1 min ago");
});

test("what the cloud does not know is left empty, or named so", () => {
  const unknown = rowOf({ id: "tb1", map: "house", state: null, battery: null, seen_ago: null, task: null, error: null, machine: null, software: null });
  assert.deepEqual([unknown.state, unknown.battery, unknown.task, unknown.error, unknown.seen, unknown.machine, unknown.software], ["unknown", "", "", "", "–", "", "unknown"]);
  assert.equal(row({ battery: 0 }).battery, "0 %");
});

test("all words of a search are to be found, in any column and case", () => {
  const rows = [row({ map: "House" }), row({ id: "tb2", map: "attic" })];
  const found = (text) => matching(rows, text).map(({ id }) => id);
  assert.deepEqual([found(""), found(" m1 house"), found("TB2 house"), found("acme")], [["tb1", "tb2"], ["tb1"], [], ["tb1", "tb2"]]);
});

test("rows are sorted by numbers in names, with empty fields last in both directions", () => {
  const ids = (rows, ...by) => sorted(rows, ...by).map(({ id }) => id);
  const named = (...names) => names.map((id) => row({ id }));
  assert.deepEqual(ids(named("tb10", "tb9"), "id", false), ["tb9", "tb10"]);
  assert.deepEqual(ids(named("tb9", "tb10"), "id", true), ["tb10", "tb9"]);
  const errors = [row({ id: "a" }), row({ id: "b", error: "x" }), row({ id: "c", error: "y" })];
  assert.deepEqual([ids(errors, "error", false), ids(errors, "error", true)], [["b", "c", "a"], ["c", "b", "a"]]);
});

test("times and charges are sorted by their numbers, unknown charges last", () => {
  const ids = (rows, ...by) => sorted(rows, ...by).map(({ id }) => id);
  const ages = [row({ id: "a", seen_ago: null }), row({ id: "b", seen_ago: 90 }), row({ id: "c" })];
  assert.deepEqual([ids(ages, "seen", false), ids(ages, "seen", true)], [["c", "b", "a"], ["a", "b", "c"]]);
  const charges = [row({ id: "a", battery: null }), row({ id: "b", battery: 1 }), row({ id: "c", battery: 0.09 })];
  assert.deepEqual([ids(charges, "battery", false), ids(charges, "battery", true)], [["c", "b", "a"], ["b", "c", "a"]]);
});

test("only the rows in view and some beside them are drawn", () => {
  assert.deepEqual(windowOf(0, 440, 44, 500), { from: 0, to: 18 });
  assert.deepEqual(windowOf(4400, 440, 44, 500), { from: 92, to: 118 });
  assert.deepEqual(windowOf(99_999, 440, 44, 5), { from: 0, to: 5 });
  assert.deepEqual(windowOf(0, 440, 44, 0), { from: 0, to: 0 });
});
