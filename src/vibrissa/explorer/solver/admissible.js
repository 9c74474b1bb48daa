// Whether a solved shape is admissible, that is possible for a rod below a surface. See docs/model.md.

import { gap } from "./gap.js";
import { bracketedRoot } from "./numerics/roots.js";
import { CLAMP_SLOPE, isStraight, naturalCurvature, tailOf } from "./rod/mounting.js";

/** How much larger than at the nodes a slope may be between them (rad). */
const NEAR = 0.05;
/** Slope (rad) up to which a tip counts as level. */
const LEVEL = 1e-9;
/** Rounding error of a height or a distance (L), or of the sine of a slope. */
const EXACTLY = 1e-12;
/** Places that are examined, as fractions of the free part: denser near the contact point, where arches are short. */
const LOOKS = 161;
const PLACES = Float64Array.from({ length: LOOKS }, (_, i) => 1 - (1 - i / (LOOKS - 1)) ** 4);
/** Accuracy of the place of a highest or lowest point (L). */
const TO_A_TURN = 1e-8;
/** Number of points of a tail that are examined. */
const TAIL_LOOKS = 16;

/** @type {Record<keyof Clearance, string>} */
const REASONS = {
  clamp: "the rod dips below the level of its clamp",
  surface: "the rod crosses the surface away from its contact point",
  itself: "the rod crosses itself",
};

/** Why a shape is inadmissible; empty if it is admissible. @type {(rod: Rod, state: State, model: Contact) => string} */
export function inadmissible(rod, state, model) {
  const room = clearance(rod, state, model);
  const limits = /** @type {(keyof Clearance)[]} */ (Object.keys(REASONS));
  const limit = limits.find((name) => room[name] < -EXACTLY);
  return limit ? REASONS[limit] : "";
}

/** Negative where a shape is inadmissible. @type {(rod: Rod, state: State, model: Contact) => number} */
export function margin(rod, state, model) {
  const { clamp, surface, itself } = clearance(rod, state, model);
  return Math.min(clamp, surface, itself) + EXACTLY;
}

/**
 * Room of a rod. With the model "point", in which only the tip may touch the surface, the rest of the rod may pass
 * through it.
 * @type {(rod: Rod, state: State, model: Contact) => Clearance}
 */
export function clearance(rod, state, model) {
  const { angle, compliance } = rod.mounting;
  const start = CLAMP_SLOPE + angle + compliance * state.m;
  const curved = !isStraight(rod.mounting);
  const slopes = state.unknowns.subarray(0, rod.nodes);
  const [low, high] = [Math.min(start, ...slopes), Math.max(start, ...slopes)];
  // Where the slope stays between 0 and π, the rod rises all the way.
  const rises = high < Math.PI - NEAR && low > (curved ? NEAR : 0);
  const { least, most } = rises ? { least: Infinity, most: -Infinity } : extremes(rod, state);
  const mayNotCross = model === "line" && (state.contact === "line" || state.phi1 >= -LEVEL);
  const tail = state.contact === "line" && curved ? tailRoom(rod, state) : { clamp: Infinity, surface: Infinity };
  return {
    clamp: Math.min(Math.sin(start), least, tail.clamp),
    surface: Math.min(mayNotCross ? state.height - most : Infinity, tail.surface),
    itself: gap(rod, state),
  };
}

/**
 * Heights of the lowest and of the highest point between clamp and contact point; infinite if there is none.
 * @type {(rod: Rod, state: State) => { least: number, most: number }}
 */
function extremes(rod, state) {
  let [least, most] = [Infinity, -Infinity];
  const s = PLACES.map((part) => part * state.sc);
  const rise = rod.slopes(state, s).map(Math.sin);
  for (let first = 0; first < LOOKS - 1; first += 1) {
    const next = first + 1;
    const falls = rise[first] > 0 && rise[next] <= 0;
    if (!falls && !(rise[first] < 0 && rise[next] >= 0)) continue;
    /** @type {(at: number) => number} */
    const steepness = (at) => Math.sin(rod.slopes(state, Float64Array.of(at))[0]);
    const turn = bracketedRoot(steepness, s[first], s[next], rise[first], rise[next], TO_A_TURN);
    const height = rod.shape(state, Float64Array.of(turn)).y[0];
    if (falls) most = Math.max(most, height);
    else least = Math.min(least, height);
  }
  return { least, most };
}

/** Room of the tail of a curved rod that lies on the surface. @type {(rod: Rod, state: State) => Omit<Clearance, "itself">} */
function tailRoom({ mounting }, { sc, height }) {
  const parts = Array.from({ length: TAIL_LOOKS }, (_, k) => (1 + k) / TAIL_LOOKS);
  const ups = parts.map((part) => tailOf(mounting, sc, sc + (1 - sc) * part).up);
  // The tail is above the surface where it rises, or begins to rise.
  const rises = Math.max(naturalCurvature(mounting, sc), ...ups);
  return { clamp: height + Math.min(...ups), surface: rises > 0 ? -rises : Infinity };
}
