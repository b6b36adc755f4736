/** Shapes of a robot. The context is in pixels; points are transformed by the view. */

const BACK = 2.5; // where the back corners of the wedge lie, from the way it faces [rad]
const DASH = 6;

/** A line through points of the world. */
export function line(context, view, points, colour, width) {
  if (points.length < 4) return;
  context.beginPath();
  for (let i = 0; i < points.length; i += 2) {
    const { x, y } = view.toScreen({ x: points[i], y: points[i + 1] });
    if (i) context.lineTo(x, y);
    else context.moveTo(x, y);
  }
  context.lineJoin = "round";
  context.lineCap = "round";
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

/** A band over cells of the world: as wide as they are, and joined where they are neighbours. */
export function band(context, view, cells, size, colour) {
  if (!cells.length) return;
  context.beginPath();
  cells.forEach(([x, y], i) => {
    const at = view.toScreen({ x, y });
    const [a, b] = cells[i - 1] ?? [Infinity, Infinity];
    if (Math.hypot(x - a, y - b) > 1.1 * size) context.moveTo(at.x - 0.01, at.y); // a path without length is not drawn
    context.lineTo(at.x, at.y);
  });
  context.lineJoin = "round";
  context.lineCap = "round";
  context.strokeStyle = colour;
  context.lineWidth = size * view.scale;
  context.stroke();
}

/** A dot for each point of the world. */
export function dots(context, view, points, colour, size) {
  context.fillStyle = colour;
  for (let i = 0; i < points.length; i += 2) {
    const { x, y } = view.toScreen({ x: points[i], y: points[i + 1] });
    context.fillRect(x - size / 2, y - size / 2, size, size);
  }
}

/** A dash for each pose, which shows its yaw. */
export function dashes(context, view, poses, colour) {
  context.beginPath();
  for (let i = 0; i < poses.length; i += 3) {
    const { x, y } = view.toScreen({ x: poses[i], y: poses[i + 1] });
    context.moveTo(x, y);
    context.lineTo(x + DASH * Math.cos(poses[i + 2]), y - DASH * Math.sin(poses[i + 2]));
  }
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.stroke();
}

/** The robot: its footprint, and a wedge that shows its heading. */
export function body(context, at, radius, theta, { colour, halo, faded, selected }) {
  context.save();
  context.translate(at.x, at.y);
  context.rotate(-theta);
  context.globalAlpha = faded ? 0.45 : 1;
  if (selected) ring(context, radius + 6, colour);
  context.beginPath();
  context.arc(0, 0, radius, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
  context.strokeStyle = halo;
  context.lineWidth = 2;
  context.stroke();
  context.beginPath();
  context.moveTo(radius * 0.72, 0);
  for (const side of [BACK, -BACK]) context.lineTo(radius * 0.66 * Math.cos(side), radius * 0.66 * Math.sin(side));
  context.closePath();
  context.fillStyle = halo;
  context.fill();
  context.restore();
}

/** A circle around what is selected. */
export function circle(context, radius, colour) {
  context.beginPath();
  context.arc(0, 0, radius, 0, 2 * Math.PI);
  context.strokeStyle = colour;
  context.lineWidth = 2.5;
  context.stroke();
}

function ring(context, radius, colour) {
  circle(context, radius, colour);
  context.save();
  context.globalAlpha = 0.16;
  context.fillStyle = colour;
  context.fill();
  context.restore();
}

/** A goal: a ring with a dot, and an arrow where the robot will face. */
export function target(context, at, theta, colour, halo) {
  context.save();
  context.translate(at.x, at.y);
  for (const [stroke, width] of [[halo, 6], [colour, 2.5]]) {
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.lineCap = "round";
    context.beginPath();
    context.arc(0, 0, 9, 0, 2 * Math.PI);
    if (Number.isFinite(theta)) arrow(context, theta);
    context.stroke();
  }
  context.beginPath();
  context.arc(0, 0, 3, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
  context.restore();
}

function arrow(context, theta) {
  const [c, s] = [Math.cos(theta), -Math.sin(theta)];
  const at = (along, aside) => [along * c - aside * s, along * s + aside * c];
  context.moveTo(...at(9, 0));
  context.lineTo(...at(28, 0));
  context.moveTo(...at(21, -6));
  context.lineTo(...at(28, 0));
  context.lineTo(...at(21, 6));
}

const fontOf = (bold) => `${bold ? 600 : 500} 12px system-ui, sans-serif`;

/** The width of a label [pixels]. */
export function widthOf(context, text, bold) {
  context.font = fontOf(bold);
  return context.measureText(text).width;
}

/** A name with a halo, legible on any background. */
export function label(context, text, x, y, ink, halo, bold) {
  context.font = fontOf(bold);
  context.textAlign = "center";
  context.textBaseline = "top";
  context.lineJoin = "round";
  context.strokeStyle = halo;
  context.lineWidth = 4;
  context.strokeText(text, x, y);
  context.fillStyle = ink;
  context.fillText(text, x, y);
}
