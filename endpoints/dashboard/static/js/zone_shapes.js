/** Shapes of zones: the polygons and lines of GeoJSON, in metres, and those that the user draws. */

/** Polygons of a geometry, each a list of rings. @param {{type: string, coordinates: any}} geometry @returns {number[][][][]} */
export function polygonsOf({ type, coordinates }) {
  if (type === "Polygon") return [coordinates];
  return type === "MultiPolygon" ? coordinates : [];
}

/** Lines of a geometry. @param {{type: string, coordinates: any}} geometry @returns {number[][][]} */
export function linesOf({ type, coordinates }) {
  if (type === "LineString") return [coordinates];
  return type === "MultiLineString" ? coordinates : [];
}

/** The place of a station; null of other geometries. @param {{type: string, coordinates: any}} geometry @returns {number[] | null} */
export function pointOf({ type, coordinates }) {
  return type === "Point" ? coordinates : null;
}

/** Whether a point lies in a zone, or in reach of its lines. @param {{x: number, y: number}} point @param {number} reach [m] */
export function within({ geometry, properties }, { x, y }, reach) {
  const half = Math.max((properties.width ?? 0) / 2, reach);
  const place = pointOf(geometry);
  if (place) return Math.hypot(place[0] - x, place[1] - y) <= reach;
  const onLine = linesOf(geometry).some((line) => line.slice(1).some((end, i) => toSegment(line[i], end, x, y) <= half));
  return onLine || polygonsOf(geometry).some((rings) => rings.reduce((inside, ring) => inside !== inRing(ring, x, y), false));
}

/** Where the name of a zone stands: in the middle of its first polygon, or of its first line. @returns {{x: number, y: number}} */
export function middleOf(geometry) {
  const place = pointOf(geometry);
  if (place) return { x: place[0], y: place[1] };
  const [line] = linesOf(geometry);
  if (line) {
    const at = Math.floor((line.length - 1) / 2);
    return { x: (line[at][0] + line[at + 1][0]) / 2, y: (line[at][1] + line[at + 1][1]) / 2 };
  }
  const [[ring]] = polygonsOf(geometry);
  const middle = (axis) => (Math.min(...ring.map((place) => place[axis])) + Math.max(...ring.map((place) => place[axis]))) / 2;
  return { x: middle(0), y: middle(1) };
}

/** The corners of a zone that is one ring, one line or a point, as text; null of one that has more. @returns {string | null} */
export function cornersOf({ type, coordinates }) {
  if (type === "Point") return coordinates.slice(0, 2).join(" ");
  const places = type === "LineString" ? coordinates : type === "Polygon" && coordinates.length === 1 ? opened(coordinates[0]) : null;
  return places && places.map(([x, y]) => `${x} ${y}`).join(", ");
}

/** The geometry with other corners, from text as "x y, x y"; null if the text has no such corners. */
export function withCorners({ type }, text) {
  const places = text.split(",").map((place) => place.trim().split(/\s+/).map(Number));
  if (type === "Point") return places.length === 1 && places[0].length === 2 && places[0].every(Number.isFinite) ? { type, coordinates: places[0] } : null;
  if (places.length < (type === "LineString" ? 2 : 3) || !places.every((place) => place.length === 2 && place.every(Number.isFinite))) return null;
  return geometryOf(places, type === "LineString");
}

function geometryOf(places, isLine) {
  return isLine ? { type: "LineString", coordinates: places } : { type: "Polygon", coordinates: [[...places, places[0]]] };
}

/** The geometry with outlines counterclockwise and holes clockwise, as RFC 7946 has them. @param {{type: string, coordinates: any}} geometry */
export function oriented({ type, coordinates }) {
  if (type === "Polygon") return { type, coordinates: turned(coordinates) };
  return { type, coordinates: type === "MultiPolygon" ? coordinates.map(turned) : coordinates };
}

function turned(rings) {
  return rings.map((ring, i) => (isClockwise(ring) === (i === 0) ? ring.toReversed() : ring));
}

function isClockwise(ring) {
  return ring.slice(1).reduce((area, [x1, y1], i) => area + ring[i][0] * y1 - x1 * ring[i][1], 0) < 0;
}

function opened(ring) {
  const [first, last] = [ring[0], ring.at(-1)];
  return ring.length > 1 && first[0] === last[0] && first[1] === last[1] ? ring.slice(0, -1) : ring;
}

function inRing(ring, x, y) {
  return ring.reduce((inside, [x1, y1], i) => {
    const [x0, y0] = ring.at(i - 1);
    return y0 > y !== y1 > y && x < x0 + ((y - y0) / (y1 - y0)) * (x1 - x0) ? !inside : inside;
  }, false);
}

function toSegment([x0, y0], [x1, y1], x, y) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const part = Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(x - x0 - part * dx, y - y0 - part * dy);
}

const FINENESS = 100; // parts of a metre that corners are rounded to
const TWICE = 400; // ms between the clicks of a double-click

/** A zone that the user draws, corner by corner. */
export class Drawing {
  /** @type {number[][]} */ corners = [];
  /** Where the pointer is. @type {{x: number, y: number} | null} */ hover = null;
  #clicked = -Infinity;
  #most;

  /** @param {string} kind of the zone @param {boolean} isLine whether it is drawn as a line @param {boolean} isPoint whether it is a place */
  constructor(kind, isLine, isPoint = false) {
    this.kind = kind;
    this.isLine = isLine;
    this.isPoint = isPoint;
    this.#most = isPoint ? 1 : kind === "door" ? 2 : Infinity;
  }

  /** Number of corners that are missing. */
  get missing() {
    return Math.max(0, (this.isPoint ? 1 : this.isLine ? 2 : 3) - this.corners.length);
  }

  /**
   * Take a click on the map; return whether it ends the drawing, as a double-click does, one on the first corner, and the last of a door or a place.
   * @param {{x: number, y: number}} point @param {number} reach [m] within which two clicks are on one place @param {number} now [ms]
   */
  click({ x, y }, reach, now) {
    const near = (place) => place && Math.hypot(place[0] - x, place[1] - y) <= reach;
    const isDouble = now - this.#clicked <= TWICE && near(this.corners.at(-1));
    this.#clicked = now;
    if (isDouble || (!this.isLine && near(this.corners[0]) && !this.missing)) return true;
    const corner = [x, y].map((value) => Math.round(value * FINENESS) / FINENESS);
    if (String(corner) !== String(this.corners.at(-1))) this.corners.push(corner);
    return this.corners.length === this.#most;
  }

  /** Take the last corner back. */
  undo() {
    this.corners.pop();
  }

  /** The geometry that was drawn; null while corners are missing. */
  get geometry() {
    if (this.isPoint) return this.missing ? null : { type: "Point", coordinates: this.corners[0] };
    return this.missing ? null : geometryOf(this.corners, this.isLine);
  }
}
