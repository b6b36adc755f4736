import assert from "node:assert/strict";
import test from "node:test";

import { Journal } from "../../../../../endpoints/dashboard/static/js/journal.js";
import { AlertWatch } from "../../../../../endpoints/dashboard/static/js/pages/alert_watch.js";

const ok = { state: "ok", reason: null };
const robot = (id, connected) => ({ id, map: "office", connected });

function scene({ isAdmin = false, robots = [], tasks = [], events = [], acknowledged = [] }) {
  const asked = [];
  const list = async (path) => (asked.push(path), path === "v1/acknowledgements" ? acknowledged : tasks);
  const post = async (path, one) => (asked.push(path), acknowledged.push({ ...one, by: "ann", time: 1000 }), acknowledged.at(-1));
  return {
    asked,
    cloud: {
      me: { id: "ann" }, isAdmin, map: "office", robots, endpoints: null, now: 1000,
      health: { store: ok, map_store: ok, audit: ok, master: "ok", disk: null, plans_waiting: 0 },
    },
    fleet: { links: [] },
    journal: new Journal(),
    failed: (error) => assert.fail(error),
    rest: { list, post, get: async (path) => (asked.push(path), { items: events }) },
  };
}

const settled = () => new Promise((done) => setTimeout(done));

test("a robot that leaves is lost until it is back; who reads no audit log learns it from the lists", async () => {
  const context = scene({ robots: [robot("tb1", true)] });
  const watch = new AlertWatch(context);
  watch.update();
  await settled();
  assert.deepEqual(watch.alerts, []);
  context.cloud.robots = [robot("tb1", false)];
  context.cloud.now = 1010;
  watch.update();
  assert.deepEqual(watch.alerts.map(({ text, since }) => [text, since]), [["tb1 is lost", 1010]]);
  assert.equal(context.journal.entries[0].bad, true);
  context.cloud.robots = [robot("tb1", true)];
  watch.update();
  assert.deepEqual(watch.alerts, []);
  assert.ok(!context.asked.some((path) => path.includes("audit")));
});

test("administrators learn from the audit log whether a connection broke off, also before the page was opened", async () => {
  const end = (object, time, code) => ({ user: "ann", object, time, details: { role: "robot", code } });
  const events = [end("robots/tb2", 990, 1000), end("robots/tb1", 980, 1006), end("robots/tb2", 970, 1006)]; // the newest first
  const context = scene({ isAdmin: true, robots: [robot("tb1", false), robot("tb2", false)], events });
  const watch = new AlertWatch(context);
  watch.update();
  await settled();
  assert.deepEqual(watch.alerts.map(({ robot: id, since }) => [id, since]), [["tb1", 980]]);
  assert.deepEqual(context.journal.entries, []);
});

test("an acknowledged alert is apart, on all pages, until it happens again", async () => {
  const task = { id: "t1", map: "office", robot: null, reason: "too late", state: "failed", ended: 900 };
  const context = scene({ tasks: [task] });
  const watch = new AlertWatch(context);
  watch.update();
  await settled();
  await watch.acknowledge("maps/office/tasks/t1 failed");
  assert.deepEqual(watch.alerts, []);
  const acknowledged = await context.rest.list("v1/acknowledgements");
  const other = new AlertWatch(scene({ tasks: [task], acknowledged }));
  other.update();
  await settled();
  assert.deepEqual(other.alerts, []);
  assert.deepEqual(other.acknowledged.map(({ key, by, time }) => [key, by, time]), [["maps/office/tasks/t1 failed", "ann", 1000]]);
  const again = new AlertWatch(scene({ tasks: [{ ...task, ended: 1050 }], acknowledged }));
  again.update();
  await settled();
  assert.equal(again.alerts.length, 1);
});

test("an acknowledgement that is refused leaves the alert open", async () => {
  const context = scene({ tasks: [{ id: "t1", map: "office", robot: null, reason: "too late", state: "failed", ended: 900 }] });
  context.rest.post = async () => Promise.reject(new Error("the store is away"));
  const watch = new AlertWatch(context);
  watch.update();
  await settled();
  await assert.rejects(watch.acknowledge("maps/office/tasks/t1 failed"), /the store is away/);
  assert.equal(watch.alerts.length, 1);
});

test("a fault of unknown begin counts from when it was seen, and its end forgets that", async () => {
  const context = scene({});
  const watch = new AlertWatch(context);
  const away = { ...context.cloud.health, master: "away" };
  const well = context.cloud.health;
  for (const [health, now] of [[away, 1000], [away, 1010], [well, 1020], [away, 1030]]) {
    context.cloud.health = health;
    context.cloud.now = now;
    watch.update();
    if (now === 1010) assert.equal(watch.alerts[0].since, 1000);
  }
  assert.equal(watch.alerts[0].since, 1030);
  await settled();
});
