import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { doing, noteOf } = await import("../../../../endpoints/dashboard/static/js/people_panel.js");

test("what is known of a person is told in words", () => {
  const person = { seen_by: ["tb1/4", "tb2/7"], group: 2 };
  assert.equal(doing(person, { robot: "tb1", reason: "nearest" }), "Followed by tb1: nearest; seen as tb1/4, tb2/7; talks (group 2)");
  assert.equal(doing({ seen_by: [], group: 0 }, null), "");
  assert.equal(doing({ seen_by: ["tb1/4"], group: 0 }, null), "Seen as tb1/4");
});

test("a missing coordinator and robots that are not trusted are reported", () => {
  const robots = [{ robot: "tb1", trusted: true, reason: "" }, { robot: "tb2", trusted: false, reason: "it contradicts all others" }];
  assert.equal(noteOf({ coordinator: "ready", reason: "", robots: robots.slice(0, 1) }), "");
  assert.equal(noteOf({ coordinator: "ready", reason: "", robots }), "tb2 is not trusted: it contradicts all others");
  assert.equal(noteOf({ coordinator: "refused", reason: "no machine", robots }), "People are not counted now: no machine");
  assert.match(noteOf({ coordinator: "starting", reason: "", robots }), /starts/);
});
