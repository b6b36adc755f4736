import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

import { colourOf, readTheme } from "../../../../endpoints/dashboard/static/js/theme.js";
import { KINDS } from "../../../../endpoints/dashboard/static/js/zones_state.js";

const CSS = readFileSync(new URL("../../../../endpoints/dashboard/static/css/theme.css", import.meta.url), "utf8");
const [LIGHT, DARK] = CSS.split("@media (prefers-color-scheme: dark)");
const LEGIBLE = 3; // contrast that graphics need, by WCAG 2

function themeOf(css) {
  globalThis.document = { documentElement: null };
  globalThis.getComputedStyle = () => ({ getPropertyValue: (name) => css.match(new RegExp(`${name}: (#\\w{6});`))?.[1] ?? "" });
  return readTheme();
}

/** The relative luminance of a colour, by WCAG 2. */
function luminance(colour) {
  const [red, green, blue] = colour.map((part) => (part / 255 <= 0.04045 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

function contrast(one, other) {
  const [dark, bright] = [luminance(one), luminance(other)].sort((a, b) => a - b);
  return (bright + 0.05) / (dark + 0.05);
}

for (const [name, css] of Object.entries({ light: LIGHT, dark: DARK })) {
  test(`each kind of zone has a colour of its own in the ${name} theme, legible on the map`, () => {
    const { zones, palette } = themeOf(css);
    assert.deepEqual(Object.keys(zones).sort(), Object.keys(KINDS).sort());
    assert.equal(new Set(Object.values(zones)).size, Object.keys(KINDS).length);
    for (const [kind, colour] of Object.entries(zones)) {
      for (const ground of [palette.free, palette.unknown]) assert.ok(contrast(colourOf(colour), ground) >= LEGIBLE, kind);
    }
  });
}
