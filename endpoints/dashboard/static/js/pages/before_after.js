/** Two pictures of the part of a map that a version changes: as it is, and as it would be. */

import { make } from "../dom.js";
import { pixelsOf } from "../grid.js";
import { readTheme } from "../theme.js";
import { cropOf, cut, shiftOf } from "./map_words.js";

const WIDEST = 420; // pixels

/** Draw a part of a grid, with the changes outlined. */
function picture(title, grid, crop, rectangles) {
  const { palette, robots } = readTheme();
  const { width, height, data } = pixelsOf(cut(grid, crop), palette, 1);
  const scale = Math.max(1, Math.floor(WIDEST / Math.max(width, height)));
  const cells = make("canvas", { width, height });
  cells.getContext("2d").putImageData(new ImageData(data, width, height), 0, 0);
  const canvas = make("canvas", { width: width * scale, height: height * scale, role: "img", "aria-label": title });
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, -scale, 0, height * scale); // rows go up, as y does
  context.imageSmoothingEnabled = false;
  context.drawImage(cells, 0, 0);
  context.strokeStyle = robots[0];
  context.lineWidth = 2 / scale;
  for (const { column, row, width: columns, height: rows } of rectangles) context.strokeRect(column - crop.column, row - crop.row, columns, rows);
  return make("figure", {}, canvas, make("figcaption", { className: "muted", textContent: title }));
}

/**
 * The pictures of a version that waits for a review.
 * @param {import("../grid.js").Grid} before @param {import("../grid.js").Grid} after
 * @param {{column: number, row: number, width: number, height: number}[]} rectangles in cells of the grid after
 */
export function beforeAndAfter(before, after, rectangles) {
  const crop = cropOf(rectangles, after.info);
  const { columns, rows } = shiftOf(after.info, before.info);
  const moved = ({ column, row, ...size }) => ({ column: column + columns, row: row + rows, ...size });
  return make("div", { className: "before-after" },
    picture("Now", before, moved(crop), rectangles.map(moved)), picture("With this change", after, crop, rectangles));
}
