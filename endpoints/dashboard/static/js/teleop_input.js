/** What a driver's hands say: keys, a pad that is touched, a gamepad. Each gives parts of the fastest speeds, or null if it is let go. */

/** @typedef {{linear: number, angular: number}} Motion parts of the fastest speeds, from -1 to 1; angular to the left */

/** @type {Record<string, Motion>} */
const KEYS = {
  KeyW: { linear: 1, angular: 0 },
  ArrowUp: { linear: 1, angular: 0 },
  KeyS: { linear: -1, angular: 0 },
  ArrowDown: { linear: -1, angular: 0 },
  KeyA: { linear: 0, angular: 1 },
  ArrowLeft: { linear: 0, angular: 1 },
  KeyD: { linear: 0, angular: -1 },
  ArrowRight: { linear: 0, angular: -1 },
};
/** Part of the way of a stick or a finger that counts as none. */
const DEAD_ZONE = 0.12;
/** Upper buttons at the shoulders, by the standard layout: one of them is the dead-man's control. */
const SHOULDERS = [4, 5];

const clamped = (value) => Math.max(-1, Math.min(1, value));

/** Skip the dead zone, and begin at 0 beyond it. @param {number} value */
function beyondDeadZone(value) {
  const part = Math.max(Math.abs(value) - DEAD_ZONE, 0) / (1 - DEAD_ZONE);
  return Math.sign(value) * Math.min(part, 1);
}

/** Whether a key drives. @param {string} code */
export const drives = (code) => Object.hasOwn(KEYS, code);

/** @param {Set<string>} held codes of keys @returns {Motion | null} */
export function motionOfKeys(held) {
  const motions = [...held].filter(drives).map((code) => KEYS[code]);
  if (!motions.length) return null;
  const sum = (name) => clamped(motions.reduce((total, motion) => total + motion[name], 0));
  return { linear: sum("linear"), angular: sum("angular") };
}

/**
 * @param {{x: number, y: number} | null} at where the pad is touched [px] @param {{left: number, top: number, width: number, height: number}} pad
 * @returns {Motion | null}
 */
export function motionOfTouch(at, pad) {
  if (!at) return null;
  const part = (value, begin, size) => beyondDeadZone(clamped((2 * (value - begin)) / size - 1));
  return { linear: -part(at.y, pad.top, pad.height) || 0, angular: -part(at.x, pad.left, pad.width) || 0 };
}

/** @param {(Gamepad | null)[]} gamepads @returns {Motion | null} of the first one whose shoulder button is held */
export function motionOfGamepads(gamepads) {
  const held = gamepads.find((pad) => pad?.connected && SHOULDERS.some((button) => pad.buttons[button]?.pressed));
  if (!held) return null;
  const [x = 0, y = 0] = held.axes;
  return { linear: -beyondDeadZone(y) || 0, angular: -beyondDeadZone(x) || 0 };
}
