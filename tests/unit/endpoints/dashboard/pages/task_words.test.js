import assert from "node:assert/strict";
import test from "node:test";

import { COLUMNS, againOf, ageOf, columnOf, floorsOf, labelsOf, lineOf, notesOf, placesOf, titleOf } from "../../../../../endpoints/dashboard/static/js/pages/task_words.js";

const task = (fields) => ({
  id: "a", kind: "go_to", places: [[1, 2, 0]], rounds: 1, priority: 0, deadline: null, labels: {}, state: "queued", robot: null,
  visited: 0, failures: 0, reason: "", created: 100, assigned: null, begun: null, ended: null, ...fields,
});
const column = (id, tasks) => columnOf(COLUMNS.find((one) => one.id === id), tasks);

test("the line of a place is read as this place", () => {
  assert.deepEqual(placesOf([{ x: 1.234, y: -0.001 }, { x: -3, y: 2.5 }].map(lineOf).join("\n")), [[1.23, 0], [-3, 2.5]]);
});

test("waiting tasks are sorted as they go: by priority, then the oldest first", () => {
  const tasks = [task({ id: "b", created: 5 }), task({ id: "c", created: 9, priority: 1 }), task({ id: "a", created: 3 })];
  assert.deepEqual(column("queued", tasks).tasks.map(({ id }) => id), ["c", "a", "b"]);
});

test("of ended tasks the last are shown, and all counted; cancelled ones are beside failed ones", () => {
  const tasks = Array.from({ length: 40 }, (_, i) => task({ id: `t${i}`, state: i % 2 ? "failed" : "cancelled", ended: i }));
  const { count, tasks: shown } = column("failed", tasks);
  assert.deepEqual([count, shown.length, shown[0].id, shown[1].id], [40, 30, "t39", "t38"]);
  assert.equal(column("done", tasks).count, 0);
});

test("tasks are told in words", () => {
  assert.equal(titleOf(task({})), "Go to 1.0, 2.0");
  assert.equal(titleOf(task({ trip: "charge" })), "Charge at 1.0, 2.0");
  assert.equal(titleOf(task({ trip: "park" })), "Park at 1.0, 2.0");
  assert.equal(titleOf(task({ kind: "pick_drop", places: [[1, 2, 0], [3, 4, 0]] })), "Pick at 1.0, 2.0, drop at 3.0, 4.0");
  assert.equal(titleOf(task({ kind: "patrol", places: [[1, 2, 0], [3, 4, 0]], rounds: 3 })), "Patrol 2 places, 3 rounds");
  const over = { places: [[1, 2, 0], [3, 4, 0]], floors: ["L1", "L2"] };
  assert.equal(titleOf(task({ kind: "pick_drop", ...over })), "Pick at 1.0, 2.0 on L1, drop at 3.0, 4.0 on L2");
  assert.equal(titleOf(task({ kind: "patrol", ...over })), "Patrol 2 places on L1, L2");
  assert.deepEqual(againOf(task({ kind: "pick_drop", ...over }), 0).floors, ["L1", "L2"]);
  assert.equal(ageOf(task({}), 165), "waits for 1 min");
  assert.equal(ageOf(task({ state: "assigned", assigned: 160 }), 165), "on its way for 5 s");
  assert.equal(ageOf(task({ state: "active", begun: 160 }), 159), "runs for 0 s");
  assert.equal(ageOf(task({ state: "cancelled", ended: 100 }), 7300), "cancelled 2 h ago");
});

test("notes have what is unusual", () => {
  assert.equal(notesOf(task({}), 0), "");
  const rich = task({ kind: "patrol", places: [[1, 2, 0], [3, 4, 0]], rounds: 2, visited: 3, priority: 5, deadline: 130, failures: 1, labels: { lift: "yes" } });
  assert.equal(notesOf(rich, 100), "priority 5 · 3 of 4 places visited · due in 30 s · failed 1 time · lift=yes");
  assert.match(notesOf(rich, 200), /late/);
  assert.doesNotMatch(notesOf({ ...rich, state: "done" }, 200), /late|due/);
});

test("holds, start times and limits are told in words", () => {
  assert.equal(ageOf(task({ not_before: 400 }), 100), "starts in 5 min");
  assert.equal(ageOf(task({ not_before: 105 }), 110), "waits for 5 s");
  assert.equal(ageOf(task({ state: "active", begun: 100, holding: 160 }), 165), "holds for 5 s");
  const limits = { needs_confirmation: true, named_robot: "tb1", weight: 2.5, run: 2, after: [{ task: "a", on: "done" }] };
  assert.equal(notesOf(task(limits), 0), "waits for your confirmation · only for tb1 · 2.5 kg · run 2 · after 1 other task");
  const { holds, weight } = againOf(task({ holds: [{ confirm: true }], weight: 2.5, after: [] }), 0);
  assert.deepEqual([holds, weight], [[{ confirm: true }], 2.5]);
});

test("a task is done again as it was, without a deadline that has passed", () => {
  assert.deepEqual(againOf(task({ deadline: 50, labels: { lift: "yes" }, priority: 2 }), 100), { kind: "go_to", places: [[1, 2, 0]], priority: 2, labels: { lift: "yes" } });
  const patrol = task({ kind: "patrol", rounds: 3, deadline: 150 });
  assert.deepEqual(againOf(patrol, 100), { kind: "patrol", places: [[1, 2, 0]], priority: 0, labels: {}, rounds: 3, deadline: 150 });
});

test("places are read a line each, with the heading in degrees", () => {
  const [first, second] = placesOf(" 1.5 2 \n\n3, -4; 180\n");
  assert.deepEqual(first, [1.5, 2]);
  assert.ok(Math.abs(second[2] - Math.PI) < 1e-9);
  for (const bad of ["", "1", "1 x", "1 2 3 4", "NaN 2", "Infinity 2"]) assert.throws(() => placesOf(bad), /place/);
});

test("places on other floors have these before them", () => {
  const text = "1 2\nL2: 3 4 90\n the roof :5, 6";
  assert.deepEqual(floorsOf(text), [null, "L2", "the roof"]);
  assert.deepEqual(placesOf(text), [[1, 2], [3, 4, Math.PI / 2], [5, 6]]);
  assert.deepEqual(floorsOf("1 2\n3 4"), []);
  assert.throws(() => placesOf("L2:"), /place/);
});

test("labels are read as pairs", () => {
  assert.deepEqual(labelsOf("lift=yes, arm = 2=3,"), { lift: "yes", arm: "2=3" });
  assert.deepEqual(labelsOf(""), {});
  for (const bad of ["lift", "=yes"]) assert.throws(() => labelsOf(bad), /no label/);
});
