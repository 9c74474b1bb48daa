// Whether a solved shape is admissible, that is possible for a rod below a surface. See docs/model.md.

import { bracketedRoot } from "./numerics/roots.js";
import { CLAMP_SLOPE, isStraight, naturalCurvature, naturalSlope, tailOf } from "./rod/mounting.js";

const LOOKS = 121;
const EVENLY = Float64Array.from({ length: LOOKS }, (_, i) => i / (LOOKS - 1));
/** How much larger than at the nodes a slope may be between them; and a turn too small for a loop (rad). */
const NEAR = 0.05;
const HALF_TURN = Math.PI - 0.3;
/** Slope (rad) up to which a tip counts as level. */
const LEVEL = 1e-9;
/** Rounding error of a height (L) or of the sine of a slope. */
const EXACTLY = 1e-12;
/** Height (L) above the surface at which a straight rod crosses it, as it may lie on the surface. */
const PASSED = 1e-6;
/** Fractions of the free part, denser near the contact point, where a rod may form a short arch. */
const PLACES = Float64Array.from({ length: LOOKS }, (_, i) => 1 - (1 - i / (LOOKS - 1)) ** 2);
/** Accuracy of the place of a highest or lowest point (L); one this close to the contact point is that point. */
const AT_CONTACT = 1e-6;
/** Number of points of a tail that are examined. */
const TAIL_LOOKS = 16;
const DIPS = "the rod dips below the level of its clamp";
const CROSSES_SURFACE = "the rod crosses the surface away from its contact point";

/**
 * Why a shape is inadmissible; empty if it is admissible. With the model "point", in which only the tip may touch
 * the surface, the rest of the rod may pass through it.
 * @type {(rod: Rod, state: State, model: Contact) => string}
 */
export function inadmissible(rod, state, model) {
  const hangs = state.contact === "line" ? tailFault(rod, state) : "";
  if (hangs) return hangs;
  const { angle, compliance } = rod.mounting;
  const start = CLAMP_SLOPE + angle + compliance * state.m;
  if (Math.sin(start) < -EXACTLY) return DIPS;
  const curved = !isStraight(rod.mounting);
  const slopes = state.unknowns.subarray(0, rod.nodes);
  const [low, high] = [Math.min(start, ...slopes), Math.max(start, ...slopes)];
  const lowest = Math.min(low, ...tailSlopes(rod, state));
  // Where the slope stays between 0 and π, the rod rises all the way.
  const rises = high < Math.PI - NEAR && low > (curved ? NEAR : 0);
  if (!rises) {
    const { least, most } = extremes(rod, state);
    if (least < -EXACTLY) return DIPS;
    const mayNotCross = model === "line" && (state.contact === "line" || state.phi1 >= -LEVEL);
    if (mayNotCross && most > state.height + (curved ? EXACTLY : PASSED)) return CROSSES_SURFACE;
  }
  if (high - lowest < HALF_TURN) return "";
  const { x, y } = rod.shape(state, EVENLY);
  return crossesItself(x, y) ? "the rod crosses itself" : "";
}

/**
 * Heights of the lowest and of the highest point between clamp and contact point; infinite if there is none.
 * @type {(rod: Rod, state: State) => { least: number, most: number }}
 */
export function extremes(rod, state) {
  let [least, most] = [Infinity, -Infinity];
  const s = PLACES.map((part) => part * state.sc);
  const rise = rod.slopes(state, s).map(Math.sin);
  for (let first = 0; first < LOOKS - 1; first += 1) {
    const next = first + 1;
    const falls = rise[first] > 0 && rise[next] <= 0;
    if (!falls && !(rise[first] < 0 && rise[next] >= 0)) continue;
    /** @type {(at: number) => number} */
    const steepness = (at) => Math.sin(rod.slopes(state, Float64Array.of(at))[0]);
    const turn = bracketedRoot(steepness, s[first], s[next], rise[first], rise[next], AT_CONTACT);
    if (turn >= state.sc - AT_CONTACT) continue;
    const height = rod.shape(state, Float64Array.of(turn)).y[0];
    if (falls) most = Math.max(most, height);
    else least = Math.min(least, height);
  }
  return { least, most };
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
