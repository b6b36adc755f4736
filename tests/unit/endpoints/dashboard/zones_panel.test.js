import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { guide, noteOf } = await import("../../../../endpoints/dashboard/static/js/zones_panel.js");
const { hoursOf, ruleOf } = await import("../../../../endpoints/dashboard/static/js/zone_form.js");

const DAYS = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];

test("drawing is explained, with the corners that are missing", () => {
  assert.match(guide({ missing: 2, isLine: false }), /^Click the corners on the map.* 2 more are needed\. A double-click or Enter/);
  assert.match(guide({ missing: 1, isLine: true }), /^Click the points of the line.* 1 more is needed\./);
  assert.doesNotMatch(guide({ missing: 0, isLine: true }), /needed/);
});

test("a place is one click", () => {
  assert.match(guide({ missing: 1, isLine: false, isPoint: true }), /^Click the place on the map/);
});

test("places of a building keep their properties in a form", () => {
  const said = { name: "a", times: [{}], strict: true };
  assert.deepEqual(ruleOf({ ...said, kind: "door", isLine: true, lift: "north" }), { name: "a", kind: "door", lift: "north" });
  assert.deepEqual(ruleOf({ ...said, kind: "door", isLine: true, lift: "" }), { name: "a", kind: "door" });
  assert.deepEqual(ruleOf({ ...said, kind: "lift", lift: "north" }), { name: "a", kind: "lift", lift: "north" });
  assert.deepEqual(ruleOf({ ...said, kind: "passage", way: "ramp", heading: 90 }), { name: "a", kind: "passage", way: "ramp", yaw: 1.570796 });
  const dock = { ...said, kind: "dock", heading: -90, dock_type: "v_shape" };
  assert.deepEqual(ruleOf({ ...dock, charges: false }), { name: "a", kind: "dock", yaw: -1.570796, dock_type: "v_shape", charges: false });
  assert.deepEqual(ruleOf({ ...said, kind: "dock", charges: true, yaw: 0.5 }), { name: "a", kind: "dock", yaw: 0.5 }, "of a station that became one");
});

test("problems are told as the cloud tells them, and changes by others", () => {
  assert.equal(noteOf({ problem: "", isOutdated: false, isChanged: false }), "");
  assert.equal(noteOf({ problem: "", isOutdated: false, isChanged: true }), "Not saved yet");
  assert.equal(noteOf({ problem: "", warnings: ["zone 'a': mended"], isOutdated: false, isChanged: true }), "Not saved yet. zone 'a': mended");
  assert.equal(noteOf({ problem: "two zones have the name 'a'", isOutdated: false, isChanged: true }), "two zones have the name 'a'");
  assert.match(noteOf({ problem: "it has changed.", isOutdated: true, isChanged: true }), /^it has changed\. Somebody else has changed the zones meanwhile: reload/);
});

test("a zone keeps a time zone of its own with its hours", () => {
  const said = { name: "a", kind: "no_stop", time_zone: "Asia/Tokyo" };
  assert.deepEqual(ruleOf({ ...said, times: [{}] }), { name: "a", kind: "no_stop", times: [{}], time_zone: "Asia/Tokyo" });
  assert.deepEqual(ruleOf({ ...said, times: [] }), { name: "a", kind: "no_stop" });
});

test("a zone has the properties of its kind, and no others", () => {
  const said = { name: "a", times: [], unit: "percent", speed: 40, robots: 2, heading: 90, strict: true };
  assert.deepEqual(ruleOf({ ...said, kind: "keep_out" }), { name: "a", kind: "keep_out" });
  assert.deepEqual(ruleOf({ ...said, kind: "speed_limit" }), { name: "a", kind: "speed_limit", percent: 40 });
  assert.deepEqual(ruleOf({ ...said, kind: "capacity" }), { name: "a", kind: "capacity", robots: 2 });
  assert.deepEqual(ruleOf({ ...said, kind: "one_way" }), { name: "a", kind: "one_way", direction: 1.570796, strict: true });
  assert.deepEqual(ruleOf({ name: "a", times: [{}], kind: "one_way", isLine: true, width: 2, strict: false }), { name: "a", kind: "one_way", width: 2, times: [{}] });
  assert.deepEqual(ruleOf({ ...said, kind: "lane", isLine: true, one_way: true }), { name: "a", kind: "lane", one_way: true });
  assert.deepEqual(ruleOf({ ...said, kind: "lane", isLine: true, one_way: false }), { name: "a", kind: "lane" });
});

test("a zone that becomes one of another kind has usual values", () => {
  const said = { name: "a", times: [] };
  assert.deepEqual(ruleOf({ ...said, kind: "speed_limit" }), { name: "a", kind: "speed_limit", max_speed: 0.5 });
  assert.deepEqual(ruleOf({ ...said, kind: "capacity" }), { name: "a", kind: "capacity", robots: 1 });
  assert.deepEqual(ruleOf({ ...said, kind: "one_way" }), { name: "a", kind: "one_way", direction: 0 });
});

test("a line that becomes one of the other kind has usual values, and a lane has no hours", () => {
  const said = { name: "a", isLine: true };
  assert.deepEqual(ruleOf({ ...said, kind: "one_way", one_way: true, times: [] }), { name: "a", kind: "one_way", width: 1 });
  assert.deepEqual(ruleOf({ ...said, kind: "lane", width: 2, strict: true, times: [{ days: ["mon"] }] }), { name: "a", kind: "lane" });
});

test("hours leave out what does not limit", () => {
  const hours = { days: DAYS, from: "00:00", to: "00:00", since: "", until: "" };
  assert.deepEqual(hoursOf(hours), {});
  assert.deepEqual(hoursOf({ ...hours, days: ["mon"], from: "22:00", to: "06:00" }), { days: ["mon"], from: "22:00", to: "06:00" });
  assert.deepEqual(hoursOf({ ...hours, since: "2026-12-24T08:00", from: "08:00" }), { from: "08:00", since: "2026-12-24T08:00" });
});
