/** Visible part of the map: converts metres of the world, y up, to pixels of the screen, y down, and back. */

/** @typedef {import("./geometry.js").Point} Point */

const CLOSEST = 800; // pixels a metre
const FARTHEST = 0.5;

export class View {
  /** @type {Point} */ centre = { x: 0, y: 0 };
  /** Scale [pixels/m]. */
  scale = 50;
  /** Size of the screen [pixels]. */
  width = 1;
  height = 1;

  /** @param {Point} point metres @returns {Point} pixels */
  toScreen({ x, y }) {
    return {
      x: (x - this.centre.x) * this.scale + this.width / 2,
      y: this.height / 2 - (y - this.centre.y) * this.scale,
    };
  }

  /** @param {Point} point pixels @returns {Point} metres */
  toWorld({ x, y }) {
    return {
      x: (x - this.width / 2) / this.scale + this.centre.x,
      y: (this.height / 2 - y) / this.scale + this.centre.y,
    };
  }

  /** Move the map with the finger. @param {number} dx pixels @param {number} dy pixels */
  pan(dx, dy) {
    this.centre = { x: this.centre.x - dx / this.scale, y: this.centre.y + dy / this.scale };
  }

  /** Zoom, and keep what is at a point there. @param {Point} at pixels @param {number} factor */
  zoom(at, factor) {
    const before = this.toWorld(at);
    this.scale = Math.min(CLOSEST, Math.max(FARTHEST, this.scale * factor));
    const after = this.toWorld(at);
    this.centre = { x: this.centre.x + before.x - after.x, y: this.centre.y + before.y - after.y };
  }

  /**
   * Show all of a box.
   * @param {{left: number, right: number, bottom: number, top: number}} box metres
   * @param {{top: number, bottom: number, side: number}} margin pixels that something else covers
   */
  fit(box, margin) {
    const wide = Math.max(1, this.width - 2 * margin.side);
    const high = Math.max(1, this.height - margin.top - margin.bottom);
    const scale = Math.min(wide / Math.max(box.right - box.left, 0.1), high / Math.max(box.top - box.bottom, 0.1));
    this.scale = Math.min(CLOSEST, Math.max(FARTHEST, scale));
    this.centre = {
      x: (box.left + box.right) / 2,
      y: (box.bottom + box.top) / 2 + (margin.top - margin.bottom) / 2 / this.scale,
    };
  }
}

/** The round length of a ruler that is at most so many pixels long. @param {number} scale @param {number} most */
export function rulerOf(scale, most) {
  const power = 10 ** Math.floor(Math.log10(most / scale));
  const metres = [5, 2, 1].map((digit) => digit * power).find((length) => length * scale <= most) ?? power;
  return { metres, pixels: metres * scale };
}
