import assert from "node:assert/strict";
import { test } from "node:test";

const { doing } = await import("../../../../endpoints/dashboard/static/js/robot_list.js");

const robot = (fields, goal = null, remaining = null) => ({ presence: "online", waits: true, connected: true, held: "", state: { exploration: null, goal, remaining }, ...fields });
const goal = (code, text = "") => ({ code, active: [0, 1, 6, 7].includes(code), word: "arrived", text });

test("a robot drives only while its goal is active and the traffic lets it", () => {
  assert.equal(doing(robot({}, goal(1), 2)), "Driving, 2.0 m to go");
  assert.equal(doing(robot({ held: "Waits for tb2, 3 s" }, goal(1), 2)), "Waits for tb2, 3 s");
  assert.equal(doing(robot({}, goal(0), 2)), "Its goal waits to begin");
  assert.equal(doing(robot({}, goal(6), 2)), "Stopping");
  assert.equal(doing(robot({ held: "Waits for tb2, 3 s" }, goal(3))), "Goal: arrived");
});

test("a robot that is not heard says why", () => {
  assert.equal(doing(robot({ presence: "silent" })), "No pose of it comes");
  assert.equal(doing(robot({ presence: "silent", connected: false })), "This page has no connection to it");
  assert.equal(doing(robot({ presence: "offline", waits: false })), "Not connected");
});

test("a robot that is stopped is said to be, whatever its goal is", () => {
  const robot = { stopped: "stopped by 'ann' since 2026-11-30 12:00:00 UTC: a pallet fell" };
  const link = { presence: "online", connected: true, state: { goal: { active: true, code: 1 }, remaining: 2 }, robot };
  assert.equal(doing(link), "Stopped by 'ann' since 2026-11-30 12:00:00 UTC: a pallet fell");
});
