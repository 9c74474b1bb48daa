// Whether a solved shape is admissible, that is possible for a rod below a surface. See docs/model.md.

import { bracketedRoot } from "./numerics/roots.js";
import { isStraight, naturalCurvature, naturalSlope, tailOf } from "./rod/mounting.js";

const LOOKS = 121;
const EVENLY = Float64Array.from({ length: LOOKS }, (_, i) => i / (LOOKS - 1));
/** How much larger than at the nodes a slope may be between them; and a turn too small for a loop (rad). */
const NEAR = 0.05;
const HALF_TURN = Math.PI - 0.3;
/** Slope (rad) up to which a tip counts as level. */
const LEVEL = 1e-9;
/** Height (L) by which a shape must pass a limit to be rejected, as only some points are examined. */
const PASSED = 1e-6;
/** The same in an exact state for an arch, as its highest point is located, and for a tail. */
const EXACTLY = 1e-12;
/** Fractions of the free part, denser near the contact point, where a rod may form a short arch. */
const PLACES = Float64Array.from({ length: LOOKS }, (_, i) => 1 - (1 - i / (LOOKS - 1)) ** 2);
/** Accuracy of a highest point (L); one this close to the contact point is the contact point. */
const AT_CONTACT = 1e-6;
/** Number of points of a tail that are examined. */
const TAIL_LOOKS = 16;
const DIPS = "the rod dips below the level of its clamp";
const CROSSES_SURFACE = "the rod crosses the surface away from its contact point";

/** Why a shape is inadmissible; empty if it is admissible. @type {(rod: Rod, state: State) => string} */
export function inadmissible(rod, state) {
  const hangs = state.contact === "line" ? tailFault(rod, state) : "";
  if (hangs) return hangs;
  const curved = !isStraight(rod.mounting);
  const slopes = state.unknowns.subarray(0, rod.nodes);
  const [low, high] = [Math.min(...slopes), Math.max(...slopes)];
  const lowest = Math.min(low, ...tailSlopes(rod, state));
  // The paper's model allows a tip that passes through the surface.
  const mayNotCross = state.contact === "line" || state.phi1 >= -LEVEL;
  const crosses = mayNotCross && curved && archHeight(rod, state) > state.height + EXACTLY;
  const rises = high < Math.PI - NEAR && !(mayNotCross && low < -LEVEL);
  if (rises && high - lowest < HALF_TURN) return crosses ? CROSSES_SURFACE : "";
  const { s, x, y } = rod.shape(state, EVENLY);
  const free = s.findIndex((value) => value >= state.sc);
  const heights = y.subarray(0, free < 0 ? LOOKS : free);
  if (Math.min(...heights) < -PASSED) return DIPS;
  if (crosses || (mayNotCross && Math.max(...heights) > state.height + PASSED)) return CROSSES_SURFACE;
  return high - lowest >= HALF_TURN && crossesItself(x, y) ? "the rod crosses itself" : "";
}

/** Height of the highest point of an arch before the contact point. @type {(rod: Rod, state: State) => number} */
function archHeight(rod, state) {
  let highest = -Infinity;
  const s = PLACES.map((part) => part * state.sc);
  const phi = rod.slopes(state, s);
  for (const first of phi.keys()) {
    if (!(phi[first] > 0 && phi[first + 1] <= 0)) continue;
    /** @type {(at: number) => number} */
    const slope = (at) => rod.slopes(state, Float64Array.of(at))[0];
    const top = bracketedRoot(slope, s[first], s[first + 1], phi[first], phi[first + 1], AT_CONTACT);
    if (top < state.sc - AT_CONTACT) highest = Math.max(highest, rod.shape(state, Float64Array.of(top)).y[0]);
  }
  return highest;
}

/** Slopes of the unloaded tail of a rod that lies on the surface. @type {(rod: Rod, state: State) => number[]} */
function tailSlopes({ mounting }, { contact, sc }) {
  if (contact !== "line" || isStraight(mounting)) return [];
  const begin = naturalSlope(mounting, sc);
  return Array.from({ length: TAIL_LOOKS }, (_, k) => {
    return naturalSlope(mounting, sc + ((1 - sc) * (k + 1)) / TAIL_LOOKS) - begin;
  });
}

/** Why the tail of a lying rod is inadmissible; empty if it is not. @type {(rod: Rod, state: State) => string} */
function tailFault({ mounting }, { sc, height }) {
  if (isStraight(mounting)) return "";
  if (naturalCurvature(mounting, sc) > EXACTLY) return CROSSES_SURFACE;
  const parts = Array.from({ length: TAIL_LOOKS }, (_, k) => (1 + k) / TAIL_LOOKS);
  const ups = parts.map((part) => tailOf(mounting, sc, sc + (1 - sc) * part).up);
  if (Math.max(...ups) > EXACTLY) return CROSSES_SURFACE;
  return height + Math.min(...ups) < -EXACTLY ? DIPS : "";
}

/** Whether two parts of a line of points cross. @type {(x: Float64Array, y: Float64Array) => boolean} */
function crossesItself(x, y) {
  /** On which side of the part from i on a point j lies. @type {(i: number, j: number) => number} */
  const side = (i, j) => (x[i + 1] - x[i]) * (y[j] - y[i]) - (y[i + 1] - y[i]) * (x[j] - x[i]);
  for (let i = 0; i < x.length - 1; i += 1) {
    for (let j = i + 2; j < x.length - 1; j += 1) {
      if (side(i, j) * side(i, j + 1) < 0 && side(j, i) * side(j, i + 1) < 0) return true;
    }
  }
  return false;
}
