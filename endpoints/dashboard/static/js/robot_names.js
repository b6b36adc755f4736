/** Places of the names of robots on the map: below a robot, or above it, where no other name is. */

const HEIGHT = 15; // pixels of a line of text
const GAP = { usual: 5, selected: 10 }; // pixels between a robot and its name

/** @typedef {{id: string, x: number, y: number, radius: number, width: number, selected: boolean}} Named robot on the screen, and the width of its name [pixels] */

/**
 * The upper edge of each name, by id. A name that has no room is left out; the selected robot has its name in any case.
 * @param {Named[]} robots
 * @returns {Map<string, number>}
 */
export function placesOf(robots) {
  const taken = [];
  const places = new Map();
  for (const robot of [...robots].sort((a, b) => Number(b.selected) - Number(a.selected))) {
    const boxes = [below(robot), above(robot)];
    const free = boxes.find((box) => !taken.some((other) => overlap(box, other))) ?? (robot.selected ? boxes[0] : null);
    if (!free) continue;
    taken.push(free);
    places.set(robot.id, free.top);
  }
  return places;
}

const gapOf = ({ selected }) => (selected ? GAP.selected : GAP.usual);
const below = (robot) => boxOf(robot, robot.y + robot.radius + gapOf(robot));
const above = (robot) => boxOf(robot, robot.y - robot.radius - gapOf(robot) - HEIGHT);
const boxOf = ({ x, width }, top) => ({ left: x - width / 2, right: x + width / 2, top, bottom: top + HEIGHT });
const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
