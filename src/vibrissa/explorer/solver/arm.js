// An equilibrium path, followed from α = 0 to one side: pushed ahead or pulled back by the clamp.

import { clearance, inadmissible, margin } from "./admissible.js";
import { isPossible } from "./beginning.js";
import { bracketedRoot } from "./numerics/roots.js";
import { isStraight, naturalCurvature } from "./rod/mounting.js";
import { solvedState, tangent } from "./rod/newton.js";
import { lateralMargin } from "./rod/stability.js";

/** First and shortest step, and the longest, in units of the first state's offset and force. */
const FIRST_STEP = 0.02;
const SHORTEST_STEP = 1e-5;
const LONGEST_STEP = 0.3;
/** Difference between guess and solution (rad): target of the step control, and upper bound. */
const AIM = 0.02;
const TOO_FAR = 0.15;
/** Accuracy (rad) of the states between landmarks; states that are shown are solved exactly. */
const OF_STEPS = 1e-7;
/** A path that needs more steps is given up. */
const MOST_STEPS = 400;
/** Slope of a tip (rad) below which a rod may arch; parts of a step that are examined; refinements of these. */
const NEARLY_LEVEL = 0.02;
/** Room (L) of a rod above its clamp, and between its parts, below which parts of a step are examined. */
const NARROW = 0.02;
const LOOKS_AHEAD = 5;
const ZOOMS = 3;
const TINY = 1e-13;
/** Rounding error of the place of an end in a step. */
const LOCATED = 1e-9;
/** Largest size of the last coefficients of the slope at which the nodes suffice for forces, and for a whole shape. */
const RESOLVED = 1e-7;
const RESOLVED_SHAPE = 1e-11;
/** A number of nodes that has to suffice for a shape. */
const MOST_NODES = 90;

/** Displacement of the clamp since α = 0. @type {(branch: Branch, state: State) => number} */
export function displacement(branch, state) {
  return (branch.x1 - state.offset) / branch.way;
}

/** Offset of the state at a displacement. @type {(branch: Branch, x0: number) => number} */
export function offsetAt(branch, x0) {
  return branch.x1 - x0 * branch.way;
}

/** Derivative of the demand −tan α along the path. @type {(knot: Knot, branch: Branch) => number} */
function demandChange(knot, branch) {
  const count = branch.rod.nodes;
  const [dfx, dfy] = [knot.change[count], knot.change[count + 1]];
  const { fx, fy } = knot.state;
  return (dfx * fy - fx * dfy) / fy ** 2;
}

/** @type {(branch: Branch, direction: number[], value: number) => Condition} */
function along({ scale, force }, [a, b, c, d], value) {
  return { offset: a / scale, fx: b / force, fy: c / force, sc: d, value };
}

/** @type {(branch: Branch, direction: number[], state: State) => number} */
function advance({ scale, force }, [a, b, c, d], state) {
  return (a * state.offset) / scale + (b * state.fx + c * state.fy) / force + d * state.sc;
}

/**
 * Knot of a state; the value of `condition` grows along the path, or falls if `sign` is -1.
 * @type {(branch: Branch, state: State, condition: Condition, sign?: number) => Knot}
 */
function knotAt(branch, state, condition, sign = 1) {
  const { rod, surface, scale: unit, force } = branch;
  const count = rod.nodes;
  const { change, factors } = tangent(rod, state, surface, condition);
  const offset = rod.offsetChange(state, change);
  const [fx, fy, sc] = change.subarray(count);
  const direction = [offset / unit, fx / force, fy / force, state.contact === "line" ? sc : 0];
  const scale = sign / Math.hypot(...direction);
  return {
    state,
    change: change.map((value) => scale * value),
    offsetChange: scale * offset,
    direction: direction.map((value) => scale * value),
    step: 0,
    exact: true,
    factors,
  };
}

/**
 * Unknowns between two knots, at a part of the way (0 to 1), by a cubic with the knots' directions.
 * @type {(from: Knot, to: Knot, part: number) => Float64Array}
 */
export function between(from, to, part) {
  const [a, b, c, d] = cubic(from, to, part);
  const [start, stop] = [from.state.unknowns, to.state.unknowns];
  return start.map((value, i) => a * value + b * stop[i] + c * from.change[i] + d * to.change[i]);
}

/**
 * Weights of both values and both changes in a cubic between two knots, at t from 0 to 1.
 * @type {(from: Knot, to: Knot, t: number) => [number, number, number, number]}
 */
export function cubic(from, to, t) {
  // Derivatives are taken along the direction of the first knot.
  const slope = from.direction.reduce((sum, value, i) => sum + value * to.direction[i], 0);
  const s = 1 - t;
  const { step } = to;
  return [s * s * (1 + 2 * t), t * t * (1 + 2 * s), step * t * s * s, (-step * t * t * s) / slope];
}

/**
 * Solve the state at a part of the way between two knots.
 * @type {(branch: Branch, from: Knot, to: Knot, part: number) => Knot | null}
 */
function knotBetween(branch, from, to, part) {
  const { rod, surface } = branch;
  const { contact } = from.state;
  const value = advance(branch, from.direction, from.state) + part * to.step;
  const closure = { surface, contact, condition: along(branch, from.direction, value) };
  const state = solvedState(rod, between(from, to, part), closure, from.factors);
  return state && knotAfter(branch, from, state);
}

/**
 * The knot between two others in which a function vanishes that has different signs in these two.
 * @type {(branch: Branch, from: Knot, to: Knot, value: (knot: Knot) => number) => Knot | null}
 */
export function knotWhere(branch, from, to, value) {
  const [low, high] = [value(from), value(to)];
  // A function may vanish at one of the two knots.
  if (low === 0 || high === 0) return low === 0 ? { ...from, step: 0 } : to;
  /** @param {number} part */
  const at = (part) => {
    const found = knotBetween(branch, from, to, part);
    return found ? value(found) : NaN;
  };
  const part = bracketedRoot(at, 0, 1, low, high, TINY);
  return Number.isNaN(part) ? null : knotBetween(branch, from, to, part);
}

/** Knot in a state that lies ahead of another knot. @type {(branch: Branch, from: Knot, state: State) => Knot} */
function knotAfter(branch, from, state) {
  const start = advance(branch, from.direction, from.state);
  const step = advance(branch, from.direction, state) - start;
  return { ...knotAt(branch, state, along(branch, from.direction, 0)), step };
}

/**
 * The next knot, by a step that is shortened until it succeeds, and the length of the following step.
 * `before` is the last but one knot, if it is on the same smooth piece.
 * @type {(branch: Branch, last: Knot, before: Knot | undefined, step: number)
 *   => { knot: Knot, next: number } | null}
 */
function stepped(branch, last, before, step) {
  const { rod, surface } = branch;
  const { contact } = last.state;
  for (let h = step; h > SHORTEST_STEP; h *= 0.4) {
    const bend = before && last.step > 0 ? (0.5 * h * h) / last.step : 0;
    const guess = last.state.unknowns.map(
      (value, i) =>
        value + h * last.change[i] + (before ? bend * (last.change[i] - before.change[i]) : 0),
    );
    const value = advance(branch, last.direction, last.state) + h;
    const condition = along(branch, last.direction, value);
    const closure = { surface, contact, condition };
    // A curved rod may have a very low arch, which only exact states show.
    const accuracy = isStraight(rod.mounting) ? OF_STEPS : undefined;
    const state = solvedState(rod, guess, closure, last.factors, accuracy);
    if (!state) continue;
    let miss = 0;
    for (let i = 0; i < rod.nodes; i += 1) {
      miss = Math.max(miss, Math.abs(guess[i] - state.unknowns[i]));
    }
    if (miss > TOO_FAR) continue;
    const growth = Math.min(2, Math.max(0.5, Math.cbrt(AIM / (miss + TINY))));
    const knot = { ...knotAt(branch, state, condition), step: h, exact: false };
    return { knot, next: Math.min(LONGEST_STEP, h * growth) };
  }
  return null;
}

/**
 * Knots on both sides of the state in which the kind of contact changes; `beyond` is past it, of the old kind.
 * @type {(branch: Branch, last: Knot, beyond: Knot) => Knot[] | null}
 */
function kink(branch, last, beyond) {
  const { rod, surface } = branch;
  const lies = last.state.contact === "point";
  const [a, b] = [last, beyond].map(({ state }) => (lies ? state.phi1 : state.sc - 1));
  const guess = between(last, beyond, Math.min(1, Math.max(0, a / (a - b))));
  const condition = { phi1: 1, value: 0 };
  const state = solvedState(rod, guess, { surface, contact: "point", condition });
  const here = state && knotAfter(branch, last, { ...state, contact: last.state.contact, phi1: 0 });
  if (!here || here.step > beyond.step) return null; // or another kink, farther on
  const there = { ...state, contact: /** @type {Contact} */ (lies ? "line" : "point"), phi1: 0 };
  return [
    here,
    // After the kink s_c falls from 1, or the slope of the tip rises from 0.
    lies ? knotAt(branch, there, { sc: 1, value: 0 }, -1) : knotAt(branch, there, condition),
  ];
}

/**
 * How and where an arm ends between two knots; null if it goes on. The clamp pushes on side 1, pulls on side -1.
 * @type {(branch: Branch, side: number, from: Knot, to: Knot) => Ending | null}
 */
function ending(branch, side, from, to) {
  const found = turning(branch, side, from, to);
  const last = found?.knot && found.knot.step > 0 ? found.knot : to;
  const beyond = firstInadmissible(branch, from, last);
  if (!beyond) return found;
  const why = inadmissible(branch.rod, beyond.state, branch.model);
  const knot = knotWhere(branch, from, beyond, ({ state }) => margin(branch.rod, state, branch.model));
  return { end: "inadmissible", knot, why };
}

/**
 * How and where an arm ends between two knots for another reason than an inadmissible shape.
 * @type {(branch: Branch, side: number, from: Knot, to: Knot) => Ending | null}
 */
function turning(branch, side, from, to) {
  const { rod, surface, round } = branch;
  const { contact } = from.state;
  /** @param {Condition} condition */
  const where = (condition) => {
    const state = solvedState(rod, to.state.unknowns, { surface, contact, condition });
    return state && knotAfter(branch, from, state);
  };
  if (to.state.fy >= 0) return { end: "lifts", knot: where({ fy: 1, value: 0 }) };
  if (round && swung(branch, to.state) <= 0) {
    const straight = isStraight(rod.mounting);
    const knot = straight ? where(onAxis(branch)) : knotWhere(branch, from, to, ({ state }) => swung(branch, state));
    return { end: "swings", knot };
  }
  if (side * to.offsetChange >= 0) {
    return { end: "snaps", knot: knotWhere(branch, from, to, (knot) => knot.offsetChange) };
  }
  return null;
}

/**
 * The first inadmissible knot after `from`, up to `to`; null if there is none.
 *
 * A rod that is curved towards the surface may arch over it on a short part of the path only, near the state
 * in which its tip is most nearly parallel to the surface. A rod may dip below its clamp, or cross itself, on a short
 * part, too.
 * @type {(branch: Branch, from: Knot, to: Knot) => Knot | null}
 */
function firstInadmissible(branch, from, to) {
  const { rod, model } = branch;
  const looks = [to];
  const mayArch = model === "line" && naturalCurvature(rod.mounting, 1) > 0 && from.state.contact === "point";
  if (mayArch && Math.min(from.state.phi1, to.state.phi1) < NEARLY_LEVEL) {
    looks.push(...nearestTo(branch, from, to, ({ state }) => Math.abs(state.phi1)));
  }
  const [room, roomNext] = [from, to].map(({ state }) => clearance(rod, state, model));
  for (const limit of /** @type {const} */ (["clamp", "itself"])) {
    if (Math.min(room[limit], roomNext[limit]) > NARROW) continue;
    looks.push(...nearestTo(branch, from, to, ({ state }) => clearance(rod, state, model)[limit]));
  }
  if (mayArch && from.state.phi1 > 0 !== to.state.phi1 > 0) {
    const level = knotWhere(branch, from, to, (knot) => knot.state.phi1);
    if (level && level.step > 0) looks.push(level);
  }
  looks.sort((one, other) => one.step - other.step);
  return looks.find((knot) => inadmissible(rod, knot.state, model)) ?? null;
}

/**
 * Knots between two others, ever closer to where a number is least.
 * @type {(branch: Branch, from: Knot, to: Knot, value: (knot: Knot) => number) => Knot[]}
 */
function nearestTo(branch, from, to, value) {
  const looks = [];
  let parts = Array.from({ length: LOOKS_AHEAD - 1 }, (_, k) => (k + 1) / LOOKS_AHEAD);
  for (let zoom = 0; zoom < ZOOMS; zoom += 1) {
    const seen = parts.map((part) => knotBetween(branch, from, to, part)).filter((knot) => knot !== null);
    looks.push(...seen);
    const values = seen.map(value);
    const near = parts[values.indexOf(Math.min(...values))];
    const width = 2 * LOOKS_AHEAD ** -(zoom + 1);
    parts = parts.map((_, k) => Math.min(near + width * ((k + 1) / LOOKS_AHEAD - 0.5), 1));
  }
  return looks;
}

/**
 * A number that is positive where a round rod stays in its plane. A straight rod does so while its contact
 * point is ahead of the axis of the unloaded clamp.
 * @type {(branch: Branch, state: State) => number}
 */
export function swung({ rod }, state) {
  if (!isStraight(rod.mounting)) return lateralMargin(rod, state);
  const { angle } = rod.mounting;
  return (state.offset + state.sc - 1) * Math.cos(angle) + state.height * Math.sin(angle);
}

/** The condition that the contact point is on the axis of the unloaded clamp. @type {(branch: Branch) => Condition} */
function onAxis({ rod, surface, scale }) {
  const [cos, sin] = [Math.cos(rod.mounting.angle), Math.sin(rod.mounting.angle)];
  const offset = (cos + surface.tilt * sin) / scale;
  return { offset, sc: cos / scale, value: (cos - surface.level * sin) / scale };
}

/** Whether an end was located in the step to a knot. @type {(knot: Knot | null, to: Knot) => boolean} */
function isWithin(knot, to) {
  return knot !== null && knot.step > -LOCATED && knot.step < to.step + LOCATED;
}

/** Whether the nodes suffice to tell whether a shape is admissible. @type {(rod: Rod, state: State) => boolean} */
export function resolvesShape(rod, state) {
  return rod.nodes >= MOST_NODES || rod.decay(state) <= RESOLVED_SHAPE;
}

/**
 * Follow a path from its first state: pushed on side 1, pulled on side -1.
 * @type {(branch: Branch, first: State, side: number) => Arm}
 */
export function followed(branch, first, side) {
  const knots = [knotAt(branch, first, { offset: 1 / branch.scale, value: 0 }, -side)];
  const mayArch = branch.model === "line" && naturalCurvature(branch.rod.mounting, 1) > 0;
  let step = FIRST_STEP;
  for (let count = 0; count < MOST_STEPS; count += 1) {
    const last = knots[knots.length - 1];
    const smooth = last.step > 0 ? knots[knots.length - 2] : undefined;
    const taken = stepped(branch, last, smooth, step);
    if (!taken) return { branch, knots, end: "lost", why: "the next state was not found" };
    const { state } = taken.knot;
    if (branch.rod.decay(state) > RESOLVED || (mayArch && !resolvesShape(branch.rod, state))) {
      return { branch, knots, end: "lost", why: "the rod bends too sharply for its nodes" };
    }
    step = taken.next;
    let found = [taken.knot];
    if (branch.model === "line" && !isPossible(taken.knot.state)) {
      const both = kink(branch, last, taken.knot);
      if (!both && taken.knot.step > FIRST_STEP * SHORTEST_STEP ** 0.5) {
        step = 0.4 * taken.knot.step;
        continue;
      }
      if (!both) return { branch, knots, end: "lost", why: "the change of contact was not found" };
      found = both;
      step = Math.min(step, FIRST_STEP);
    }
    const end = ending(branch, side, last, found[0]);
    if (end && !isWithin(end.knot, found[0])) {
      // The step is too long for its states to be solved.
      step = 0.4 * taken.knot.step;
      continue;
    }
    if (end?.knot) {
      if (end.end === "inadmissible" && !resolvesShape(branch.rod, end.knot.state)) {
        return { branch, knots, end: "lost", why: "the rod bends too sharply for its nodes" };
      }
      if (end.knot.step > 0) knots.push(...withExtremes(branch, last, end.knot));
      return { branch, knots, end: end.end, why: end.why ?? "" };
    }
    knots.push(...withExtremes(branch, last, found[0]), ...found.slice(1));
    // In a kink a path may turn back.
    if (found.length > 1 && side * found[1].offsetChange >= 0) {
      return { branch, knots: knots.slice(0, -1), end: "snaps", why: "" };
    }
  }
  return { branch, knots, end: "lost", why: "the path is too long" };
}

/**
 * The knot `to`, and before it the knot in which the demand has an extreme, if there is one in between.
 * @type {(branch: Branch, from: Knot, to: Knot) => Knot[]}
 */
function withExtremes(branch, from, to) {
  if (demandChange(from, branch) > 0 === demandChange(to, branch) > 0) return [to];
  const found = knotWhere(branch, from, to, (knot) => demandChange(knot, branch));
  if (!found || found === to) return [to];
  // Up to its error, the extreme may be at `from`.
  const extreme = { ...found, step: Math.max(found.step, 0), exact: true };
  const rest = advance(branch, extreme.direction, to.state) - advance(branch, extreme.direction, extreme.state);
  return rest > TINY ? [extreme, { ...to, step: rest }] : [extreme];
}
