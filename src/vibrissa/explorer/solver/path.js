// A sticking curve: both arms of the path of one rod at one height, and states and onsets on it.

import { inadmissible } from "./admissible.js";
import { between, cubic, displacement, followed, knotWhere, offsetAt, resolvesShape, swung } from "./arm.js";
import { beginningOf } from "./beginning.js";
import { bracketedRoot } from "./numerics/roots.js";
import { IDEAL } from "./rod/mounting.js";
import { solvedState } from "./rod/newton.js";
import { Rod } from "./rod/rod.js";
import { demand } from "./rod/state.js";

/** Numbers of nodes that are tried. */
const NODES = [20, 26, 34, 46, 64, 90];
/** Accuracy, as a part of a step, of the guess of a state; and of a displacement between two knots. */
const ROUGHLY = 1e-3;
const CLOSELY = 1e-9;
/** Rounding error of a force. */
const ROUNDING = 1e-9;
/** Lowest and largest height at which a period can begin, if the height changes from period to period. */
export const HEIGHTS = { low: 0.05, high: 0.998 };

/**
 * Solve the path of a rod on at least `fewest` nodes, a number that was enough for a similar rod.
 * Without a path the message says what to try.
 * @type {(given: Given, fewest?: number) => { path: Path | null, message: string }}
 */
export function solvedPath(given, fewest = 0) {
  const { theta, eta, contact, mounting = IDEAL } = given;
  if ((mounting.making?.bore ?? 0) * theta >= 1) {
    return { path: null, message: "the bore is wider than the tip: try a smaller bore, or a θ closer to 1" };
  }
  let message = "no state with α = 0 was found: try a larger η or a θ closer to 1";
  for (const nodes of NODES.filter((count) => count >= fewest)) {
    const rod = new Rod(theta, nodes, mounting);
    const begun = beginningOf(rod, eta, contact);
    if (begun === "") continue;
    if (typeof begun === "string") return { path: null, message: begun };
    const branch = branchOf(rod, given, begun);
    const why = unsuitable(branch, begun.state);
    if (why && !resolvesShape(rod, begun.state)) continue;
    if (why) return { path: null, message: why };
    const pushed = followed(branch, begun.state, 1);
    message = `the path was lost (${pushed.why}): try a slightly different θ or η`;
    if (pushed.end === "lost") continue;
    return { path: assembled(pushed, followed(branch, begun.state, -1)), message: "" };
  }
  return { path: null, message };
}

/** @type {(rod: Rod, given: Given, begun: Beginning) => Branch} */
function branchOf(rod, { eta, contact, round }, { state, ideal }) {
  const tilt = Math.tan(rod.mounting.stage);
  const surface = { level: eta - tilt * state.offset, tilt };
  const unit = { scale: ideal.offset, force: -ideal.fy };
  const way = Math.cos(rod.mounting.stage);
  return { rod, eta, model: contact, round, x1: state.offset, way, surface, ...unit };
}

/** Why no period can begin in a state; empty if one can. @type {(branch: Branch, state: State) => string} */
function unsuitable(branch, state) {
  const why = inadmissible(branch.rod, state, branch.model);
  if (why) return `with α = 0 ${why}`;
  const leaves = branch.round && swung(branch, state) <= 0;
  return leaves ? "the round rod leaves its plane with α = 0 already: try a planar one" : "";
}

/** @type {(pushed: Arm, pulled: Arm) => Path} */
function assembled(pushed, pulled) {
  const { branch, knots } = pushed;
  const last = knots[knots.length - 1];
  // Where the normal force vanishes, the demand grows without limit: above 0 if the clamp pushes the tip forward there,
  // below 0 if it pushes the tip back.
  const lifts = pushed.end === "lifts";
  const slips = lifts && last.state.fx < 0;
  // The demand is largest in a landmark, an exact state. A state next to it may exceed it by its error.
  const landmarks = knots.filter((knot) => knot.exact && !(lifts && knot === last));
  const lock = landmarks.reduce((best, knot) => (demand(knot.state) > demand(best.state) ? knot : best));
  const inside = ["lifts", "swings", "snaps"].includes(pushed.end) || demand(lock.state) > demand(last.state);
  return {
    branch,
    pushed,
    pulled,
    lock: inside && !slips ? lock : null,
    muLock: slips ? Infinity : inside ? demand(lock.state) : NaN,
    x0End: displacement(branch, last.state),
    x0Pulled: displacement(branch, pulled.knots[pulled.knots.length - 1].state),
  };
}

/**
 * The states of an arm in which `value` rises through zero, one after the other; `condition` is the same as an equation.
 * @type {(arm: Arm, value: (state: State) => number, condition: Condition) => Generator<State, void, void>}
 */
export function* rises({ branch, knots }, value, condition) {
  for (let i = 1; i < knots.length; i += 1) {
    const [from, to] = [knots[i - 1], knots[i]];
    if (!(value(from.state) < 0 && value(to.state) >= 0 && to.step > 0)) continue;
    const found = solvedBetween(branch, from, to, value, condition);
    const state = found ?? knotWhere(branch, from, to, (knot) => value(knot.state))?.state;
    if (state) yield state;
  }
}

/**
 * The first state of an arm, at x0 beyond `after` on its side, in which `value` rises through zero.
 * @type {(arm: Arm, value: (state: State) => number, condition: Condition, after?: number) => State | null}
 */
function firstRise(arm, value, condition, after = 0) {
  for (const state of rises(arm, value, condition)) {
    if (Math.abs(displacement(arm.branch, state)) >= Math.abs(after)) return state;
  }
  return null;
}

/**
 * Solve the state between two knots in which a condition holds; the cubic between them gives the guess.
 * @type {(branch: Branch, from: Knot, to: Knot, value: (state: State) => number, condition: Condition)
 *   => State | null}
 */
function solvedBetween(branch, from, to, value, condition) {
  const { rod, surface } = branch;
  const { contact } = from.state;
  /** @param {number} part */
  const at = (part) => value(rod.state(between(from, to, part), contact));
  const part = bracketedRoot(at, 0, 1, value(from.state), value(to.state), ROUGHLY);
  const state = solvedState(rod, between(from, to, part), { surface, contact, condition });
  const ahead = state && (displacement(branch, state) - displacement(branch, from.state));
  const way = displacement(branch, to.state) - displacement(branch, from.state);
  return ahead !== null && ahead / way >= 0 && ahead / way <= 1 ? state : null;
}

/**
 * The exact onset of slip ahead, the first state at x0 ≥ `after` with −tan α = μ0; null where the tip sticks to the end
 * of the path, or slips back before. Differences of forces show it, as tan α jumps to the other sign where the normal
 * force vanishes.
 * @type {(path: Path, mu0: number, after?: number) => State | null}
 */
export function onset({ branch, pushed, muLock }, mu0, after = 0) {
  if (mu0 > muLock) return null;
  const slip = firstRise(pushed, ({ fx, fy }) => mu0 * fy - fx, { fx: 1, fy: -mu0, value: 0 }, after);
  const back = slip && backOnset(pushed, mu0, after);
  return back && displacement(branch, back) < displacement(branch, slip) ? null : slip;
}

/**
 * The last state up to x0 in which a tip that had to slip forward sticks again, −tan α = μ0.
 * @type {(path: Path, mu0: number, x0: number) => State | null}
 */
export function regained({ branch, pushed }, mu0, x0) {
  const held = [...rises(pushed, ({ fx, fy }) => fx - mu0 * fy, { fx: 1, fy: -mu0, value: 0 })];
  return held.filter((state) => displacement(branch, state) <= x0).pop() ?? null;
}

/**
 * The state in which the tip slips back, tan α = μ0: a pulled tip on the pulled arm, a pushed one on the pushed arm.
 * @type {(arm: Arm, mu0: number, after?: number) => State | null}
 */
export function backOnset(arm, mu0, after = 0) {
  return firstRise(arm, ({ fx, fy }) => fx + mu0 * fy, { fx: 1, fy: mu0, value: 0 }, after);
}

/**
 * The last state before x0 > 0 with α = 0 in which the tip, pushed back before, is pushed forward again; null if none.
 * @type {(path: Path, x0: number) => State | null}
 */
export function uprightBefore({ branch, pushed }, x0) {
  const found = [...rises(pushed, ({ fx }) => ROUNDING - fx, { fx: 1, value: ROUNDING })];
  return found.filter((state) => displacement(branch, state) < x0).pop() ?? null;
}

/**
 * The first state in which the rod lies down, or would penetrate the surface.
 * @type {(path: Path) => State | null}
 */
export function touch(path) {
  const { knots } = path.pushed;
  if (knots[0].state.phi1 < 0) return knots[0].state;
  const lies = knots.find(({ state }) => state.contact === "line");
  if (lies) return lies.state;
  return firstRise(path.pushed, (state) => -state.phi1, { phi1: 1, value: 0 });
}

/**
 * The state at a displacement; null if the path does not reach it or no state is found.
 * @type {(path: Path, x0: number) => State | null}
 */
export function stateAt(path, x0) {
  const { branch } = path;
  const { knots } = x0 < 0 ? path.pulled : path.pushed;
  const side = x0 < 0 ? -1 : 1;
  if (x0 === 0) return knots[0].state;
  /** @param {Knot} knot */
  const beyond = (knot) => side * (displacement(branch, knot.state) - x0) >= 0;
  const index = knots.findIndex(beyond);
  if (index < 1) return null;
  const [from, to] = [knots[index - 1], knots[index]];
  // At the end, perhaps a limit point, the state is known exactly.
  if (index === knots.length - 1 && displacement(branch, to.state) === x0) return to.state;
  const offset = offsetAt(branch, x0);
  const guess = between(from, to, partOf(from, to, offset));
  const { contact } = from.state;
  const closure = { surface: branch.surface, contact, condition: { offset: 1, value: offset } };
  const state = solvedState(branch.rod, guess, closure, from.factors);
  // Next to a limit point two states have the same displacement.
  if (state && Math.abs(state.unknowns[0] - guess[0]) < 0.02) return state;
  return knotWhere(branch, from, to, (knot) => offset - knot.state.offset)?.state ?? null;
}

/**
 * Part of the way between two knots at which the offset has a value, by the cubic between them.
 * @type {(from: Knot, to: Knot, offset: number) => number}
 */
function partOf(from, to, offset) {
  const [start, stop] = [from.state.offset, to.state.offset];
  /** @param {number} part */
  const away = (part) => {
    const [a, b, c, d] = cubic(from, to, part);
    return a * start + b * stop + c * from.offsetChange + d * to.offsetChange - offset;
  };
  return bracketedRoot(away, 0, 1, start - offset, stop - offset, CLOSELY);
}

/** Sample a path from end to end, each step in `parts` parts. @type {(path: Path, parts: number) => Curve} */
export function sampled({ branch, pulled, pushed }, parts) {
  const behind = samples(branch, pulled.knots, parts).reverse();
  const rows = [...behind.slice(0, -1), ...samples(branch, pushed.knots, parts)];
  const [x0, fx, fy, m, energy] = rows[0].map((_, k) => rows.map((row) => row[k]));
  return { x0, fx, fy, m, energy, demand: fx.map((value, i) => value / fy[i]) };
}

/** x0, fx, fy, m and energy. @type {(branch: Branch, knots: Knot[], parts: number) => number[][]} */
function samples(branch, knots, parts) {
  const known = knots.map((knot) => course(branch, knot));
  const rows = [];
  for (let i = 1; i < knots.length; i += 1) {
    if (knots[i].step === 0) continue;
    const [from, to] = [known[i - 1], known[i]];
    for (let k = 0; k < parts; k += 1) {
      const [a, b, c, d] = cubic(knots[i - 1], knots[i], k / parts);
      const at = from.values.map((value, j) => a * value + b * to.values[j] + c * from.changes[j] + d * to.changes[j]);
      rows.push(sample(branch, at));
    }
  }
  rows.push(sample(branch, known[known.length - 1].values));
  return rows;
}

/**
 * Offset, height, fx, fy, s_c and energy, and their derivatives along the path; the plots follow from these.
 * @type {(branch: Branch, knot: Knot) => { values: number[], changes: number[] }}
 */
function course({ rod, surface }, { state, change, offsetChange }) {
  const { offset, height, fx, fy, sc, unknowns } = state;
  const [dfx, dfy, dsc] = change.subarray(rod.nodes);
  const { tilt } = surface;
  return {
    values: [offset, height, fx, fy, sc, rod.energyOf(unknowns)],
    // The energy grows by the work of the stage, (M7) of docs/mounting.md.
    changes: [offsetChange, tilt * offsetChange, dfx, dfy, dsc, (fx + tilt * fy) * offsetChange],
  };
}

/** @type {(branch: Branch, values: number[]) => number[]} */
function sample(branch, [offset, height, fx, fy, sc, energy]) {
  // The moment of the contact force about the clamp.
  return [(branch.x1 - offset) / branch.way, fx, fy, fy * (offset - 1 + sc) - fx * height, energy];
}
