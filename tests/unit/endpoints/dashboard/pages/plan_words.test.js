import assert from "node:assert/strict";
import test from "node:test";

import { OF_PLAN, OF_PLANNER, milliseconds, percent, reuseText, storedText } from "../../../../../endpoints/dashboard/static/js/pages/plan_words.js";

test("fractions and times that are unknown are a dash", () => {
  assert.deepEqual([percent(0.256), percent(null), milliseconds(0.0123), milliseconds(null)], ["26 %", "–", "12.3 ms", "–"]);
});

test("the share of paths that were used again is that of all planners together", () => {
  assert.equal(reuseText([{ reused: 3, stitched: 1, computed: 4 }, { reused: 0, stitched: 0, computed: 2 }]), "Of the paths that were asked for, 40 % were not computed.");
  assert.equal(reuseText([]), "No path was asked for yet.");
});

test("what is stored is told, also of an empty map", () => {
  assert.equal(storedText({ plans: 2, waypoints: 100, kept: 75, bytes: 5 }, (bytes) => `${bytes} B`), "2 paths stored in 5 B, 25 % of their waypoints shared");
  assert.equal(storedText({ plans: 0, waypoints: 0, kept: 0, bytes: 0 }, (bytes) => `${bytes} B`), "0 paths stored in 0 B");
});

test("rows have what the cloud answers", () => {
  const plan = { user: "ann", robot: "tb1", start: [1, 2, 0], goal: [3, 4, 0], length: 5.04, planner: "dijkstra", origin: "stitched", seconds: 0.002 };
  assert.deepEqual(OF_PLAN.map(([, text]) => text(plan, "now")), ["now", "tb1 of ann", "1.0, 2.0", "3.0, 4.0", "5.0 m", "dijkstra", "stitched", "2.0 ms"]);
  const planner = { planner: "astar", queries: 10, success: 0.9, reuse_rate: null, computed: 9, reused: 0, stitched: 0, seconds: null };
  assert.deepEqual(OF_PLANNER.map(([, text]) => text(planner)), ["astar", "10", "90 %", "–", "9", "0", "0", "–"]);
});
