/** Picture of the occupancy grid, painted once and drawn in each frame. */

import { cellsAPixel, pixelsOf } from "./grid.js";

export class MapPicture {
  #grid;
  #canvas = document.createElement("canvas");
  #step;

  /** @param {import("./grid.js").Grid} grid @param {import("./grid.js").Palette} palette */
  constructor(grid, palette) {
    this.#grid = grid;
    this.#step = cellsAPixel(grid.info);
    this.paint(palette);
  }

  /** Paint it anew. @param {import("./grid.js").Palette} palette */
  paint(palette) {
    const { width, height, data } = pixelsOf(this.#grid, palette, this.#step);
    this.#canvas.width = width;
    this.#canvas.height = height;
    this.#canvas.getContext("2d").putImageData(new ImageData(data, width, height), 0, 0);
  }

  /** Outline rectangles of cells. @param {CanvasRenderingContext2D} context in metres @param {number} width of a line [m] */
  mark(context, rectangles, colour, width) {
    const { origin, resolution } = this.#grid.info;
    context.save();
    context.translate(origin.x, origin.y);
    context.rotate(origin.theta);
    context.strokeStyle = colour;
    context.lineWidth = width;
    for (const { column, row, width: columns, height: rows } of rectangles) {
      context.strokeRect(column * resolution, row * resolution, columns * resolution, rows * resolution);
    }
    context.restore();
  }

  /** Draw it where it lies: its rows go up, as y does. @param {CanvasRenderingContext2D} context in metres */
  draw(context, scale) {
    const { origin, resolution } = this.#grid.info;
    const edge = resolution * this.#step;
    context.save();
    context.translate(origin.x, origin.y);
    context.rotate(origin.theta);
    context.scale(edge, edge);
    context.imageSmoothingEnabled = edge * scale < 2; // seen closely, cells are squares
    context.drawImage(this.#canvas, 0, 0);
    context.restore();
  }
}
