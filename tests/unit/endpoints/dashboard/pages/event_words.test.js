import assert from "node:assert/strict";
import test from "node:test";

import { chosen, kindOf, lineOf, lineOfEntry, pathOf, timeText } from "../../../../../endpoints/dashboard/static/js/pages/event_words.js";

const event = (fields) => ({
  number: 7, time: 100, user: "ann", address: "", action: "remove_map", object: "maps/office", outcome: "ok", status: 204, reason: null, details: {}, repeats: 0, ...fields,
});

test("events have a kind, and a refusal counts as one whatever it was", () => {
  assert.equal(kindOf(event({})), "changes");
  assert.equal(kindOf(event({ action: "connect" })), "connections");
  for (const action of ["log_in", "create_user", "share_robot", "revoke_token", "end_sessions"]) assert.equal(kindOf(event({ action })), "access");
  assert.equal(kindOf(event({ action: "log_in", outcome: "refused" })), "refusals");
});

test("an event is told with all that the log has", () => {
  const line = lineOf(event({ user: null, action: "put_robot", outcome: "refused", status: 403, reason: "not-permitted", address: "10.0.0.3", details: { map: "office", limits: { cores: 2 } }, repeats: 3 }));
  assert.equal(line.who, "unknown");
  assert.equal(line.what, "put robot");
  assert.equal(line.details, 'not permitted (403), map office, limits {"cores":2}, from 10.0.0.3, and 3 more like it');
});

test("lines are chosen by kind, robot and user, and come the newest first", () => {
  const seen = (robot, time) => lineOfEntry({ number: time, time, robot, text: "arrived", bad: false });
  const lines = [lineOf(event({ number: 1, time: 50 })), seen("tb1", 60), seen("tb2", 70), lineOf(event({ number: 2, time: 80, action: "connect" }))];
  const all = { kind: "all", robot: "", user: "" };
  assert.deepEqual(chosen(lines, all).map(({ time }) => time), [80, 70, 60, 50]);
  assert.deepEqual(chosen(lines, { ...all, kind: "robots" }).map(({ who }) => who), ["tb2", "tb1"]);
  assert.deepEqual(chosen(lines, { ...all, robot: "tb1" }).map(({ time }) => time), [80, 60, 50]); // the cloud has chosen its events itself
  assert.deepEqual(chosen(lines, { ...all, user: "ann" }).map(({ time }) => time), [80, 50]);
});

test("the cloud is asked for what is chosen, whatever the names are", () => {
  assert.equal(pathOf({ user: "", robot: "" }, { limit: 5 }), "v1/audit?limit=5");
  assert.equal(pathOf({ user: "a&b", robot: "tb 1" }, {}), "v1/audit?user=a%26b&object=robots%2Ftb+1");
});

test("another day is said", () => {
  const now = new Date(2026, 10, 30, 12).getTime() / 1000;
  assert.ok(timeText(now - 86_400, now).length > timeText(now - 60, now).length);
});
