/** Occupancy grids: their pose and their pixels. */

import { place } from "./geometry.js";

/**
 * @typedef {{resolution: number, width: number, height: number, origin: import("./geometry.js").Pose}} GridInfo
 * @typedef {{info: GridInfo, cells: Int8Array}} Grid cells row by row from the lowest; 0–100, -1 unknown
 * @typedef {[number, number, number]} Colour
 * @typedef {{free: Colour, occupied: Colour, unknown: Colour}} Palette
 */

/** Largest side of a browser's canvas [pixels]; in larger maps several cells share a pixel. */
const LARGEST = 4096;

/** The box around a grid, whichever way it is turned [m]. @param {GridInfo} info */
export function boundsOf({ resolution, width, height, origin }) {
  const [w, h] = [width * resolution, height * resolution];
  const corners = [[0, 0], [w, 0], [0, h], [w, h]].map(([x, y]) => place(origin, { x, y }));
  const [xs, ys] = [corners.map((corner) => corner.x), corners.map((corner) => corner.y)];
  return { left: Math.min(...xs), right: Math.max(...xs), bottom: Math.min(...ys), top: Math.max(...ys) };
}

/** Cells along the edge of one pixel. @param {GridInfo} info @param {number} largest */
export function cellsAPixel({ width, height }, largest = LARGEST) {
  return Math.ceil(Math.max(width, height) / largest);
}

/** The colour of each value of a cell, by its byte. @param {Palette} palette @returns {Uint32Array} RGBA, as in memory */
export function coloursOf({ free, occupied, unknown }) {
  const bytes = new Uint8ClampedArray(256 * 4);
  for (let value = 0; value < 256; value += 1) {
    const share = value <= 100 ? value / 100 : 0;
    const colour = value <= 100 ? free.map((from, i) => from + (occupied[i] - from) * share) : unknown;
    bytes.set([...colour, 255], value * 4);
  }
  return new Uint32Array(bytes.buffer);
}

/**
 * The pixels of a grid, lowest row first. Where several cells share a pixel, the most occupied shows.
 * @param {Grid} grid @param {Palette} palette
 */
export function pixelsOf({ info, cells }, palette, step = cellsAPixel(info)) {
  const colours = coloursOf(palette);
  const [width, height] = [Math.ceil(info.width / step), Math.ceil(info.height / step)];
  const pixels = new Uint32Array(width * height);
  for (let row = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1) {
      const value = step === 1 ? cells[row * info.width + column] : mostOccupied(info, cells, row, column, step);
      pixels[row * width + column] = colours[value & 255];
    }
  }
  return { width, height, data: new Uint8ClampedArray(pixels.buffer) };
}

/** @param {GridInfo} info @param {Int8Array} cells */
function mostOccupied(info, cells, row, column, step) {
  let most = -1;
  for (let r = row * step; r < Math.min((row + 1) * step, info.height); r += 1) {
    for (let c = column * step; c < Math.min((column + 1) * step, info.width); c += 1) {
      most = Math.max(most, cells[r * info.width + c]);
    }
  }
  return most;
}
