import assert from "node:assert/strict";
import test from "node:test";

const { TrafficState, cellOf, hasTraffic } = await import("../../../../endpoints/dashboard/static/js/traffic_state.js");

const robot = (id, state, fields = {}) => ({ robot: id, state, pose: [1.1, 2, 0], way: [[0, 2], [1, 2]], waits_for: "", goal: null, waited: 0, ...fields });

const answer = (at, goals, ...robots) => ({ at, spacing: 0.5, goals, robots });

test("a map has traffic while a traffic node of the user runs for it", () => {
  const node = { kind: "traffic", user: "ann", map: { id: "house" }, state: "ready" };
  assert.equal(hasTraffic([node], "ann", "house"), true);
  assert.deepEqual([hasTraffic([node], "bob", "house"), hasTraffic([node], "ann", "attic"), hasTraffic([], "ann", null)], [false, false, false]);
  assert.equal(hasTraffic([{ ...node, state: "starting" }, { ...node, kind: "robot" }], "ann", "house"), false);
});

test("a robot stands in the nearest cell that it holds", () => {
  assert.deepEqual(cellOf(robot("tb1", "waiting")), [1, 2]);
  assert.deepEqual(cellOf(robot("tb1", "waiting", { way: [] })), [1.1, 2]);
});

test("time of waiting is added up by cell", () => {
  const state = new TrafficState();
  state.take(answer(10, 0, robot("tb1", "waiting", { waited: 30 })));
  assert.deepEqual([state.waits, state.longest], [[], 0], "the page has not looked that long");
  state.take(answer(12, 0, robot("tb1", "waiting", { waited: 32 }), robot("tb2", "driving", { waited: 0 })));
  state.take(answer(15, 0, robot("tb1", "waiting", { waited: 1, way: [[1, 2], [1, 2.5]], pose: [1, 2.4, 0] })));
  state.take(answer(16, 0, robot("tb2", "waiting", { waited: 9 })));
  assert.deepEqual(state.waits, [{ x: 1, y: 2, size: 0.5, seconds: 3 }, { x: 1, y: 2.5, size: 0.5, seconds: 1 }]);
  assert.equal(state.longest, 3);
});

test("a robot that waits is held by another one, or by something else", () => {
  const state = new TrafficState();
  assert.equal(state.heldBy("tb1"), "");
  state.take(answer(1, 0, robot("tb1", "waiting", { waits_for: "tb2", waited: 3.5 }), robot("tb2", "driving"), robot("tb3", "waiting", { waited: 90 })));
  assert.deepEqual(["tb1", "tb2", "tb3"].map((id) => state.heldBy(id)), ["Waits for tb2, 3 s", "", "Waits, 1 min"]);
  state.pause();
  assert.equal(state.heldBy("tb1"), "");
});

test("goals are counted by their differences, in a minute and in an hour", () => {
  const state = new TrafficState();
  state.take(answer(0, 100));
  assert.deepEqual(state.throughput, { minute: 0, hour: 0, seconds: 0 });
  state.take(answer(1, 101));
  state.take(answer(50, 101));
  state.take(answer(70, 103));
  assert.deepEqual(state.throughput, { minute: 2, hour: 3, seconds: 70 });
  state.take(answer(5000, 103));
  assert.deepEqual(state.throughput, { minute: 0, hour: 0, seconds: 3600 });
});

test("goals reached while the page was hidden are spread over that time", () => {
  const state = new TrafficState();
  state.take(answer(0, 0));
  state.take(answer(600, 30));
  assert.deepEqual(state.throughput, { minute: 3, hour: 30, seconds: 600 });
});

test("a traffic node that begins anew counts from 0", () => {
  const state = new TrafficState();
  state.take(answer(0, 7));
  state.take(answer(1, 2));
  assert.equal(state.throughput.minute, 2);
});

test("what was counted is kept while no robot takes part, and forgotten on another map", () => {
  const state = new TrafficState();
  state.take(answer(0, 0, robot("tb1", "waiting", { waited: 5 })));
  state.take(answer(1, 1, robot("tb1", "waiting", { waited: 6 })));
  state.picked = "tb1";
  state.pause();
  assert.deepEqual([state.answer, state.longest, state.throughput.hour, state.picked], [null, 1, 1, "tb1"]);
  state.take(answer(2, 1));
  assert.equal(state.picked, null, "it is gone");
  state.clear();
  assert.deepEqual([state.waits, state.throughput], [[], { minute: 0, hour: 0, seconds: 0 }]);
});
