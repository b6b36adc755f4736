import assert from "node:assert/strict";
import test from "node:test";

import { addCardPart, addPage, createCardParts, pagesInOrder } from "../../../../endpoints/dashboard/static/js/registry.js";

test("pages and parts of the card come in their order, not in that of loading", () => {
  addPage({ id: "b", title: "B", order: 2, create: () => null });
  addPage({ id: "a", title: "A", order: 1, create: () => null });
  assert.deepEqual(pagesInOrder().map(({ id }) => id), ["a", "b"]);
  addCardPart(2, ({ rest }) => ({ element: `second of ${rest}`, update: () => {} }));
  addCardPart(1, ({ rest }) => ({ element: `first of ${rest}`, update: () => {} }));
  assert.deepEqual(createCardParts({ rest: "x" }).map(({ element }) => element), ["first of x", "second of x"]);
});
