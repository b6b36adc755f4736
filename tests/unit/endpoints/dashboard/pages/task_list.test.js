import assert from "node:assert/strict";
import test from "node:test";

import { TaskList } from "../../../../../endpoints/dashboard/static/js/pages/task_list.js";

function store(tasks) {
  const asked = [];
  const open = ({ state }) => ["queued", "assigned", "active"].includes(state);
  return {
    asked,
    tasks,
    list: async (path) => (asked.push(path), tasks.filter((task) => !path.endsWith("?state=open") || open(task)).map((task) => ({ ...task }))),
    get: async (path) => (asked.push(path), { ...tasks.find(({ id }) => path.endsWith(`/${id}`)) }),
  };
}

const states = (list) => Object.fromEntries(list.tasks.map(({ id, state }) => [id, state]));

test("ended tasks are read once; one that ends is asked for alone", async () => {
  const rest = store([{ id: "a", state: "done" }, { id: "b", state: "queued" }]);
  const list = new TaskList(rest);
  await list.read("tasks", 0);
  rest.tasks[1].state = "failed";
  rest.tasks.push({ id: "c", state: "queued" });
  await list.read("tasks", 2);
  assert.deepEqual(states(list), { a: "done", b: "failed", c: "queued" });
  assert.deepEqual(rest.asked, ["tasks", "tasks?state=open", "tasks/b"]);
});

test("a task that came and ended between two looks is found later", async () => {
  const rest = store([]);
  const list = new TaskList(rest);
  await list.read("tasks", 0);
  rest.tasks.push({ id: "a", state: "failed" });
  await list.read("tasks", 2);
  assert.deepEqual(states(list), {});
  await list.read("tasks", 40);
  assert.deepEqual(states(list), { a: "failed" });
});

test("many that end at once are read together", async () => {
  const rest = store(Array.from({ length: 30 }, (_, i) => ({ id: `t${i}`, state: "queued" })));
  const list = new TaskList(rest);
  await list.read("tasks", 0);
  for (const task of rest.tasks) task.state = "cancelled";
  await list.read("tasks", 2);
  assert.deepEqual(new Set(Object.values(states(list))), new Set(["cancelled"]));
  assert.deepEqual(rest.asked, ["tasks", "tasks?state=open", "tasks"]);
});

test("tasks of another map that arrive late are not shown", async () => {
  const rest = store([{ id: "a", state: "queued" }]);
  const list = new TaskList(rest);
  const late = list.read("first", 0);
  await list.read(null, 0);
  await late;
  assert.deepEqual(list.tasks, []);
});
