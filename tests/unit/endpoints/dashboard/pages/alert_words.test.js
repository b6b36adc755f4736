import assert from "node:assert/strict";
import test from "node:test";

import { HELD, brokeOff, brokenParts, failedGoals, failedTasks, faultsOf, isAcknowledged, lostRobots, mayAcknowledge, robotOf, silentEndpoints } from "../../../../../endpoints/dashboard/static/js/pages/alert_words.js";

const ok = { state: "ok", reason: null };
const HEALTH = { store: ok, map_store: ok, audit: ok, master: "ok", disk: { state: "ok", reason: null }, plans_waiting: 0 };

test("a cloud that is well has no fault", () => {
  assert.deepEqual(faultsOf(HEALTH), []);
  assert.deepEqual(faultsOf({ ...HEALTH, disk: null }), []);
  assert.deepEqual(faultsOf(null), []);
});

test("each fault of the cloud is named, with its reason if one is known", () => {
  const ill = { ...HEALTH, store: { state: "away", reason: "no route to host" }, map_store: { state: "away", reason: null }, master: "away", disk: { state: "full", reason: "free 2 GiB" }, plans_waiting: 7 };
  const found = faultsOf(ill);
  assert.deepEqual(found.map(({ object, alert }) => [object, alert]), ["store", "map_store", "master", "disk", "plans"].map((name) => ["cloud", name]));
  assert.equal(found[0].advice, "no route to host");
  assert.match(found[1].advice, /Robots drive on/);
  assert.match(found[4].text, /^7 paths wait/);
});

test("silent endpoints, lost robots, failed goals and failed tasks are alerts", () => {
  assert.deepEqual(silentEndpoints(null), []);
  assert.equal(silentEndpoints([{ id: "e1", machine: "m1", state: "silent" }, { id: "e2", machine: "m1", state: "ready" }]).length, 1);
  const robots = [{ id: "tb1", connected: false }, { id: "tb2", connected: true }, { id: "tb3", connected: false }, { id: "tb4", connected: null }];
  const lost = new Map([["tb1", 5], ["tb2", 6], ["tb4", 7]]);
  assert.deepEqual(lostRobots(robots, lost).map(({ robot, since }) => [robot, since]), [["tb1", 5]]);
  const goal = (code, text = "") => ({ robot: { id: "tb1" }, state: { goal: { code, id: "g", word: "gave up", text } } });
  assert.equal(failedGoals([goal(4, "no way")])[0].advice, "no way");
  assert.deepEqual(failedGoals([goal(3), goal(1), { robot: { id: "tb2" }, state: { goal: null } }]), []);
  const task = (state, ended) => ({ id: "t", map: "office", robot: null, reason: "too late", state, ended });
  assert.deepEqual(failedTasks([task("failed", 100), task("cancelled", 100), task("failed", 200_000)], 200_001).map(({ since }) => since), [200_000]);
});

test("lifts and doors that serve nobody are alerts of their building", () => {
  const lifts = [{ lift: "north", fault: "fire", serves: false, mode: "fire" }, { lift: "south", fault: "in use by 'x'", serves: true, mode: "agv" }];
  const doors = [{ floor: "L1", door: "gate", fault: "jammed", mode: "offline" }, { floor: "L1", door: "main", fault: "", mode: "open" }];
  assert.deepEqual(brokenParts({ address: "inn", state: { lifts, doors } }).map(({ object, alert, advice }) => [object, alert, advice]), [
    ["buildings/inn", "lift north", "fire"], ["buildings/inn", "door gate on L1", "jammed"],
  ]);
  assert.deepEqual(brokenParts(null), []);
  assert.deepEqual([mayAcknowledge({ object: "buildings/inn" }, [], false), mayAcknowledge({ object: "buildings/bob:inn" }, [], true)], [true, false]);
});

test("an acknowledgement counts for what began before it", () => {
  const given = { time: 100 };
  assert.equal(isAcknowledged({ since: 90 }, undefined, 110), false);
  assert.equal(isAcknowledged({ since: 90, earlier: false }, given, 110), true);
  assert.equal(isAcknowledged({ since: 105, earlier: false }, given, 110), false);
  assert.equal(isAcknowledged({ since: 105, earlier: false, once: true }, given, 110), true); // a goal fails once
  assert.equal(isAcknowledged({ since: 105, earlier: true }, given, 110), true); // it was there when the page was opened
  assert.equal(isAcknowledged({ since: 105, earlier: true }, given, 100 + HELD), false);
});

test("who may not drive a robot, or administer the cloud, is offered no acknowledgement", () => {
  const robots = [{ id: "tb1", role: "administer" }, { id: "bob:tb2", role: "look" }];
  const may = (object, isAdmin) => mayAcknowledge({ object }, robots, isAdmin);
  assert.deepEqual([may("robots/tb1", false), may("robots/bob:tb2", true), may("robots/gone", true)], [true, false, false]);
  assert.deepEqual([may("maps/office/tasks/t1", false), may("cloud", false), may("endpoints/e1", true)], [true, false, true]);
});

test("the name of a goal's alert has at most 200 characters, none of them cut", () => {
  const goal = { code: 4, id: "🤖".repeat(300), word: "gave up", text: "" };
  const [{ alert }] = failedGoals([{ robot: { id: "tb1" }, state: { goal } }]);
  assert.equal([...alert].length, 200);
  assert.ok(alert.isWellFormed());
});

test("a farewell is no loss, and operators are no robots", () => {
  assert.equal(brokeOff({ details: { role: "robot", code: 1006 } }), true);
  assert.equal(brokeOff({ details: { role: "robot", code: 1000 } }), false);
  assert.equal(brokeOff({ details: { role: "robot", code: 1001 } }), false);
  assert.equal(brokeOff({ details: { role: "operator", code: 1006 } }), false);
});

test("robots of others have their owners' names", () => {
  assert.equal(robotOf({ user: "ann", object: "robots/tb1" }, "ann"), "tb1");
  assert.equal(robotOf({ user: "bob", object: "robots/tb1" }, "ann"), "bob:tb1");
  assert.equal(robotOf({ user: "bob", object: "robots/ann:tb1" }, "ann"), "ann:tb1");
  assert.equal(robotOf({ user: "bob", object: null }, "ann"), "");
});
