/** What a cloud does while it is starting, in words. */

/** @param {{status: string, kernels: {done: number, total: number, compiling: string[]} | null}} health @returns {string} empty if it is not */
export function startText({ status, kernels }) {
  if (status !== "starting") return "";
  if (!kernels) return "The cloud is starting…";
  const now = kernels.compiling.length ? ` (now ${kernels.compiling.join(", ")})` : "";
  return `The cloud is starting: compiling kernels, ${kernels.done} of ${kernels.total}${now}. Robots connect when it is ready.`;
}
