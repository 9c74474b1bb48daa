// The clamp moves and the tip sticks, slips, locks: docs/model.md and docs/simulate.md.

import { displacement } from "./arm.js";
import { bracketedRoot } from "./numerics/roots.js";
import { backOnset, onset, regained, stateAt, touch, uprightBefore } from "./path.js";
import { isIdealRod } from "./rod/mounting.js";
import { demand } from "./rod/state.js";

/** Intervals over which the energy of a slip is summed, and how often a tip may slide back. */
const STRETCHES = 24;
export const MOST_SLIDES = 100;
const TOLERANCE = 1e-12;
/** Displacements that differ by less are the same. */
export const SAME = 1e-9;

/**
 * Find where sticking ends. A tip at x0 past the critical state may stick at a friction at which a tip before it slips.
 * @type {(path: Path, friction: Friction, x0?: number) => Sticking}
 */
export function stickingOf(path, friction, x0 = 0) {
  const { branch, pushed, pulled } = path;
  /** @param {State | null} state */
  const at = (state) => (state ? displacement(branch, state) : NaN);
  const holds = at(regained(path, friction.mu0, x0));
  const past = !Number.isNaN(holds);
  const slip = at(onset(path, friction.mu0, past ? holds : 0));
  const back = at(backOnset(pushed, friction.mu0, past ? holds : 0));
  const low = past ? holds : at(backOnset(pulled, friction.mu0));
  /** @type {[number, Limit][]} */
  const limits = [
    [slip, "slips"],
    [back, "slips back"],
    [path.x0End, pushed.end],
  ];
  const known = limits.filter(([x0]) => !Number.isNaN(x0));
  const [high, highBy] = known.reduce((a, b) => (b[0] < a[0] ? b : a));
  return {
    path,
    friction,
    ahead: friction.mu0,
    behind: -friction.mu0,
    high,
    highBy,
    low: Number.isNaN(low) ? path.x0Pulled : low,
    lowBy: Number.isNaN(low) ? "lost" : "slips",
    touch: at(touch(path)),
    lock: Number.isNaN(slip) && path.lock ? at(path.lock.state) : NaN,
  };
}

/**
 * Move the clamp. If the move is `stepped`, the tip slips at the end of the step that passes the onset, as in
 * the paper; otherwise at the exact onset. On an oblique stage, where a path holds for one period only, the
 * move stops at the end of the period.
 * @type {(sticking: Sticking, from: Place, clamp: number, stepped: boolean) => Move}
 */
export function moved(sticking, from, clamp, stepped = false) {
  /** @type {Incident[]} */
  const events = [];
  let place = from;
  // In each turn of the loop the tip sticks up to the target, or up to the end of sticking.
  for (;;) {
    const aim = place.x0 + place.side * (clamp - place.clamp);
    const limit = limitOf(sticking, place.x0, aim);
    // Lateral buckling is located exactly, also within a step.
    const exact = limit && (!stepped || limit.by === "swings");
    const until = exact ? limit.x0 : aim;
    const at = exact ? place.clamp + place.side * (limit.x0 - place.x0) : clamp;
    events.push(...passed(sticking, place, limit ? limit.x0 : aim));
    if (!limit) return { place: { ...place, clamp, x0: aim }, events };
    // After lateral buckling an ideally mounted rod trails behind, mirrored; for others the motion is unknown.
    const mirrored = limit.by === "swings" && isMirrored(sticking.path);
    const after = limit.by === "slips" ? restOf(sticking, until) : 0;
    const lost = Number.isNaN(after);
    const [rest, side] = mirrored ? [limit.x0, -place.side] : [lost ? 0 : after, place.side];
    const period = limit.x0 - rest;
    const slides = !mirrored && Math.abs(period) < SAME;
    const what = lost ? "flies off" : slides && limit.by === "slips" ? "slides along" : limit.by;
    events.push({ what, clamp: at, x0: limit.x0, rest, side });
    // A tip that comes to rest where it slips keeps its distance from the clamp.
    if (slides) return { place: { clamp, x0: rest, side }, events };
    place = { clamp: at, x0: rest, side };
    if ((stepped && limit.by !== "swings") || isOblique(sticking.path) || rest < sticking.low) return { place, events };
    // On a level stage all periods are the same: only the last of those that are left is passed.
    const whole = mirrored ? 0 : Math.max(0, Math.floor((aim - limit.x0) / period) - 1);
    place.clamp += side * whole * period;
  }
}

/** Whether the height changes as the clamp moves. @type {(path: Path) => boolean} */
export function isOblique({ branch }) {
  return branch.surface.tilt !== 0;
}

/** Whether a rod is in the mirrored state after lateral buckling. @type {(path: Path) => boolean} */
export function isMirrored(path) {
  return isIdealRod(path.branch.rod.mounting) && !isOblique(path);
}

/**
 * Limit that ends sticking before `aim`; a tip that friction no longer holds at x0 is at its limit.
 * @type {(sticking: Sticking, x0: number, aim: number) => { x0: number, by: Limit } | null}
 */
export function limitOf({ low, lowBy, high, highBy }, x0, aim) {
  if (aim > high + TOLERANCE) return { x0: Math.max(high, x0), by: highBy };
  return aim < low - TOLERANCE ? { x0: Math.min(low, x0), by: lowBy } : null;
}

/** Events that the rod passes while the tip sticks. @type {(sticking: Sticking, place: Place, to: number) => Incident[]} */
export function passed(sticking, { clamp, x0: from, side }, to) {
  const lies = sticking.path.branch.model === "line";
  /** @type {[number, Incident["what"], Incident["what"]][]} */
  const marks = [
    [sticking.touch, lies ? "lies down" : "passes through", lies ? "peels off" : "comes free"],
    [sticking.lock, "locks", "unlocks"],
  ];
  return marks
    .filter(([at]) => from < at !== to < at && at > 0)
    .map(([at, up, down]) => {
      return { what: to > from ? up : down, clamp: clamp + side * (at - from), x0: at, rest: at, side };
    });
}

/**
 * Displacement at which a slipping tip comes to rest; NaN if it does not in known states.
 * @type {(sticking: Sticking, from: number) => number}
 */
export function restOf({ path, friction }, from) {
  const { mu0, ratio, law } = friction;
  if (law === "free") {
    const upright = uprightBefore(path, from);
    return upright ? displacement(path.branch, upright) : 0;
  }
  if (law === "kinetic") {
    const state = from > 0 ? onset(path, ratio * mu0) : backOnset(path.pulled, ratio * mu0);
    return state ? displacement(path.branch, state) : NaN;
  }
  // A step may end beyond the known states.
  let x0 = Math.max(path.x0Pulled, Math.min(path.x0End, from));
  for (let slide = 0; slide < MOST_SLIDES; slide += 1) {
    x0 = slideEnd(path, ratio * mu0, x0);
    const state = stateAt(path, x0);
    if (!state || Math.abs(demand(state)) <= mu0) return state ? x0 : NaN;
  }
  return NaN;
}

/**
 * Displacement at which kinetic friction has consumed the energy of a slide; NaN beyond the known states.
 * @type {(path: Path, kinetic: number, from: number) => number}
 */
function slideEnd(path, kinetic, from) {
  const ahead = from > 0 ? -1 : 1;
  const end = ahead < 0 ? path.x0Pulled : path.x0End;
  /** @param {number} x0 */
  const excess = (x0) => {
    const state = stateAt(path, x0);
    return state ? ahead * state.fx + kinetic * state.fy : NaN;
  };
  /** @type {(a: number, b: number) => number} */
  const gained = (a, b) =>
    (Math.abs(b - a) / 6) * (excess(a) + 4 * excess(0.5 * (a + b)) + excess(b));
  const step = (ahead * Math.abs(from)) / STRETCHES;
  let energy = 0;
  for (let x0 = from; ahead * (end - x0) > 0; x0 += step) {
    const next = ahead < 0 ? Math.max(end, x0 + step) : Math.min(end, x0 + step);
    const after = energy + gained(x0, next);
    if (Number.isNaN(after)) return NaN;
    if (after <= 0) {
      const [start, before] = [x0, energy];
      /** @param {number} at */
      const left = (at) => before + gained(start, at);
      return bracketedRoot(left, start, next, Math.max(before, TOLERANCE), after, TOLERANCE);
    }
    energy = after;
  }
  return NaN;
}
