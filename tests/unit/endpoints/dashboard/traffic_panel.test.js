import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { doing, reached } = await import("../../../../endpoints/dashboard/static/js/traffic_panel.js");

const robot = (state, fields = {}) => ({ state, waits_for: "", waited: 0, goal: null, way: [[0, 0]], ...fields });

test("what a robot does is told in words", () => {
  const waiting = robot("waiting", { waits_for: "tb3", waited: 12.7, goal: [4, -2.04], way: [[0, 0], [1, 0]] });
  assert.equal(doing(waiting), "Waits for tb3, 12 s; goal 4.0, -2.0; holds 2 cells");
  assert.equal(doing(robot("driving", { goal: [1, 1] })), "Goal 1.0, 1.0; holds 1 cell");
  assert.equal(doing(robot("idle")), "Holds 1 cell");
  assert.equal(doing(robot("free", { way: [] })), "Drives freely: it is alone");
});

test("robots that are not planned for say why", () => {
  assert.match(doing(robot("stopped")), /^Does not get on: others are planned around it; holds 1 cell$/);
  assert.match(doing(robot("stray")), /^Has left its way/);
  assert.match(doing(robot("by_hand")), /^Is driven by hand/);
  assert.match(doing(robot("held")), /^Is stopped/);
  assert.match(doing(robot("silent")), /^Says nothing/);
  assert.match(doing(robot("out", { way: [] })), /^Taken out/);
  const nowhere = robot("no_cells", { way: [], waits_for: "lane 'a' is too short", goal: [1, 1] });
  assert.equal(doing(nowhere), "There are no cells for it: lane 'a' is too short; goal 1.0, 1.0");
});

test("goals reached are told for the time that the page has looked", () => {
  assert.equal(reached({ minute: 1, hour: 1, seconds: 20 }), "1 goal reached in the last minute");
  assert.equal(reached({ minute: 2, hour: 30, seconds: 700 }), "2 goals reached in the last minute, 30 in the last 11 min");
  assert.equal(reached({ minute: 0, hour: 90, seconds: 3600 }), "0 goals reached in the last minute, 90 in the last hour");
});
