import assert from "node:assert/strict";
import { test } from "node:test";

globalThis.document = { createElement: () => ({ append() {}, setAttribute() {}, addEventListener() {} }), addEventListener() {} };
const { summaryOf } = await import("../../../../endpoints/dashboard/static/js/diagnosis.js");

const NOTE = { level: "ok" };

test("errors and warnings are counted, whether or not the robot is heard", () => {
  const findings = [{ level: "error" }, { level: "warn" }, { level: "warn" }, NOTE];
  for (const silent of [false, true]) assert.equal(summaryOf(findings, silent), "1 error, 2 warnings");
});

test("a robot without findings is well only if it is heard", () => {
  assert.equal(summaryOf([NOTE], false), "All is well");
  assert.match(summaryOf([NOTE], true), /^The cloud finds nothing wrong, but no pose/);
});
