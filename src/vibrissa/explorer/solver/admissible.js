// Whether a solved shape is one that a rod beside a surface can have: docs/model.md.

/** @import { Rod, State } from "./equilibrium.js" */

const LOOKS = 121;
/** Slope by which a shape may miss a limit at its nodes, and what turns less than a loop does. */
const NEAR = 0.05;
const HALF_TURN = Math.PI - 0.3;
/** Slope that is none, where the rod comes to lie on the surface. */
const LEVEL = 1e-6;
/** Height by which a shape must pass its limit to count, as it is looked at in points alone. */
const PASSED = 1e-6;

/**
 * Say how a shape is inadmissible.
 *
 * @param {Rod} rod
 * @param {State} state
 * @param {number} eta
 * @returns {string} Empty where it is admissible.
 */
export function inadmissible(rod, state, eta) {
  const slopes = state.unknowns.subarray(0, rod.nodes);
  const [low, high] = [Math.min(...slopes), Math.max(...slopes)];
  // A tip that passes through the surface is the paper's own.
  const mayNotCross = state.contact === "line" || state.phi1 >= 0;
  const arches = mayNotCross && low < -LEVEL;
  if (high < Math.PI - NEAR && !arches && high - low < HALF_TURN) return "";
  const { s, x, y } = rod.shape(state, LOOKS);
  const free = s.findIndex((value) => value >= state.sc);
  const heights = y.subarray(0, free < 0 ? LOOKS : free);
  if (Math.min(...heights) < -PASSED) return "the rod dips below the level of its clamp";
  if (mayNotCross && Math.max(...heights) > eta + PASSED) {
    return "the rod crosses the surface away from its contact point";
  }
  return high - low >= HALF_TURN && crossesItself(x, y) ? "the rod crosses itself" : "";
}

/**
 * @param {Float64Array} x
 * @param {Float64Array} y
 * @returns {boolean} Whether two parts of a line of points cross.
 */
function crossesItself(x, y) {
  /**
   * @param {number} i
   * @param {number} j
   * @returns {number} On which side of the part from i on a point j lies.
   */
  const side = (i, j) => (x[i + 1] - x[i]) * (y[j] - y[i]) - (y[i + 1] - y[i]) * (x[j] - x[i]);
  for (let i = 0; i < x.length - 1; i += 1) {
    for (let j = i + 2; j < x.length - 1; j += 1) {
      if (side(i, j) * side(i, j + 1) < 0 && side(j, i) * side(j, i + 1) < 0) return true;
    }
  }
  return false;
}
