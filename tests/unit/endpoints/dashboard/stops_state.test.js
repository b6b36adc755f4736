import assert from "node:assert/strict";
import test from "node:test";

import { appliesTo, inWords, releasePath } from "../../../../endpoints/dashboard/static/js/stops_state.js";

const ALL = { user: "ann", scope: "all", name: "", by: "bob", since: 0, reason: "a pallet fell" };
const HALL = { ...ALL, scope: "map", name: "hall", reason: "" };
const TB1 = { ...ALL, scope: "robot", name: "tb1" };

test("a stop applies to the robots of its owner alone", () => {
  const robot = { id: "tb1", user: "ann", map: "hall" };
  assert.deepEqual([ALL, HALL, TB1].map((stop) => appliesTo(stop, robot)), [true, true, true]);
  assert.deepEqual([ALL, HALL, TB1].map((stop) => appliesTo(stop, { ...robot, user: "bob" })), [false, false, false]);
  assert.deepEqual([ALL, HALL, TB1].map((stop) => appliesTo(stop, { id: "tb2", user: "ann", map: "yard" })), [true, false, false]);
  assert.equal(appliesTo(TB1, { ...robot, id: "ann:tb1" }), true, "a shared robot has its address as its id");
});

test("a stop names who stopped what and why, and whose robots they are", () => {
  assert.match(inWords(ALL, "ann"), /^All robots are stopped by bob since .+: a pallet fell$/);
  assert.match(inWords(HALL, "ann"), /^All robots on map hall are stopped by bob since [^:]+.*$/);
  assert.match(inWords(TB1, "bob"), /^ann: tb1 is stopped by bob since /);
});

test("each stop is released by its name", () => {
  assert.equal(releasePath(ALL, "ann"), "v1/release");
  assert.equal(releasePath(HALL, "ann"), "v1/maps/hall/release");
  assert.equal(releasePath(TB1, "ann"), "v1/robots/tb1/release");
  assert.equal(releasePath(TB1, "bob"), "v1/robots/ann%3Atb1/release");
});
