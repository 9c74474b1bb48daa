// A sticking curve: both arms of the path of one rod at one height, and what is read off it.

import { demand, Rod } from "./equilibrium.js";
import { between, displacement, followed, hermite, stateWhere } from "./arm.js";
import { firstState } from "./beginning.js";

/** @import { Contact, State } from "./equilibrium.js" */
/** @import { Arm, Branch, Knot } from "./arm.js" */

/** Numbers of nodes that are tried. */
const NODES = [20, 26, 34, 46, 64, 90];

/**
 * @typedef {object} Path
 * @property {Branch} branch
 * @property {Arm} pushed
 * @property {Arm} pulled
 * @property {Knot | null} lock The critical state; null where −tan α has no maximum.
 * @property {number} muLock Infinite where the tip lifts off; NaN where the path ends before.
 * @property {number} x0End Displacement at the end of the pushed arm.
 * @property {number} x0Pulled The same of the pulled arm, negative.
 */

/**
 * Solve the path of a rod.
 *
 * @param {{ theta: number, eta: number, contact: Contact, round: boolean }} rod
 * @param {number} [fewest] Nodes to begin with, as they were enough for a similar rod.
 * @returns {{ path: Path | null, message: string }} The message says what to try without a path.
 */
export function solvedPath({ theta, eta, contact, round }, fewest = 0) {
  let message = "no state with α = 0 was found: try a larger η or a θ closer to 1";
  for (const nodes of NODES.filter((count) => count >= fewest)) {
    const rod = new Rod(theta, nodes);
    const first = firstState(rod, eta, contact);
    if (!first) continue;
    const branch = { rod, eta, model: contact, round, x1: first.offset, force: -first.fy };
    const pushed = followed(branch, first, 1);
    message = `the path was lost (${pushed.why}): try a slightly different θ or η`;
    if (pushed.end === "lost") continue;
    return { path: assembled(pushed, followed(branch, first, -1)), message: "" };
  }
  return { path: null, message };
}

/**
 * @param {Arm} pushed
 * @param {Arm} pulled
 * @returns {Path}
 */
function assembled(pushed, pulled) {
  const { branch, knots } = pushed;
  const lock = knots.reduce((best, knot) =>
    demand(knot.state) > demand(best.state) ? knot : best,
  );
  const last = knots[knots.length - 1];
  const inside = lock !== last || pushed.end === "swings" || pushed.end === "snaps";
  const lifts = pushed.end === "lifts";
  return {
    branch,
    pushed,
    pulled,
    lock: inside && !lifts ? lock : null,
    muLock: lifts ? Infinity : inside ? demand(lock.state) : NaN,
    x0End: displacement(branch, last.state),
    x0Pulled: displacement(branch, pulled.knots[pulled.knots.length - 1].state),
  };
}

/**
 * The first state of an arm in which a function of it rises through zero.
 *
 * @param {Arm} arm
 * @param {(state: State) => number} value
 * @returns {State | null}
 */
function firstRise({ branch, knots }, value) {
  for (let i = 1; i < knots.length; i += 1) {
    const rises = value(knots[i - 1].state) < 0 && value(knots[i].state) >= 0;
    if (rises && knots[i].step > 0) return stateWhere(branch, knots[i - 1], knots[i], value);
  }
  return null;
}

/**
 * The exact onset of slip ahead: the first state with −tan α = μ0.
 *
 * @param {Path} path
 * @param {number} mu0
 * @returns {State | null} null where the tip locks.
 */
export function onset(path, mu0) {
  return mu0 > path.muLock ? null : firstRise(path.pushed, (state) => demand(state) - mu0);
}

/**
 * The state in which a pulled tip slips: tan α = μ0.
 *
 * @param {Path} path
 * @param {number} mu0
 * @returns {State | null} null where that is beyond the friction to which the path was followed.
 */
export function pulledOnset(path, mu0) {
  return firstRise(path.pulled, (state) => -demand(state) - mu0);
}

/**
 * The state in which a locked tip slips back: tan α = μ0, past the lock.
 *
 * @param {Path} path
 * @param {number} mu0
 * @returns {State | null}
 */
export function backOnset(path, mu0) {
  return firstRise(path.pushed, (state) => -demand(state) - mu0);
}

/**
 * The first state in which the rod lies down on the surface, or its tip would pass through it.
 *
 * @param {Path} path
 * @returns {State | null}
 */
export function touch(path) {
  const { knots } = path.pushed;
  if (knots[0].state.phi1 < 0) return knots[0].state;
  const lies = knots.find(({ state }) => state.contact === "line");
  return lies ? lies.state : firstRise(path.pushed, (state) => -state.phi1);
}

/**
 * The state at a displacement.
 *
 * @param {Path} path
 * @param {number} x0 Between both ends of the path.
 * @returns {State | null} null where the displacement is not on the path, or no state is found.
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
  if (displacement(branch, to.state) === x0) return to.state;
  const guess = between(from, to, partOf(from, to, branch.x1 - x0));
  const condition = { offset: 1, value: branch.x1 - x0 };
  const state = branch.rod.solve(guess, branch.eta, from.state.contact, condition, from.factors);
  // Next to a limit point two states have the same displacement.
  if (state && Math.abs(state.unknowns[0] - guess[0]) < 0.02) return state;
  return stateWhere(branch, from, to, ({ offset }) => branch.x1 - x0 - offset);
}

/**
 * Part of the way between two knots at which the offset has a value, by the cubic between them.
 *
 * @param {Knot} from
 * @param {Knot} to
 * @param {number} offset
 * @returns {number}
 */
function partOf(from, to, offset) {
  const slope = from.direction.reduce((sum, value, i) => sum + value * to.direction[i], 0);
  let [low, high] = [0, 1];
  const falls = to.state.offset < from.state.offset;
  for (let k = 0; k < 40; k += 1) {
    const part = 0.5 * (low + high);
    const [a, b, c, d] = hermite(part);
    const value =
      a * from.state.offset +
      b * to.state.offset +
      to.step * (c * from.offsetChange + (d * to.offsetChange) / slope);
    if (value > offset === falls) low = part;
    else high = part;
  }
  return 0.5 * (low + high);
}

/**
 * A path as a table, dense enough to be drawn.
 *
 * @typedef {object} Curve
 * @property {number[]} x0
 * @property {number[]} fx
 * @property {number[]} fy
 * @property {number[]} m
 * @property {number[]} energy
 */

/**
 * Sample a path from the last pulled state to its end.
 *
 * @param {Path} path
 * @param {number} parts Into which each step is divided.
 * @returns {Curve}
 */
export function sampled({ branch, pulled, pushed }, parts) {
  /** @type {Curve} */
  const curve = { x0: [], fx: [], fy: [], m: [], energy: [] };
  const behind = samples(branch, pulled.knots, parts).reverse();
  for (const [x0, fx, fy, m, energy] of [...behind.slice(0, -1), ...samples(branch, pushed.knots, parts)]) {
    curve.x0.push(x0);
    curve.fx.push(fx);
    curve.fy.push(fy);
    curve.m.push(m);
    curve.energy.push(energy);
  }
  return curve;
}

/**
 * @param {Branch} branch
 * @param {Knot[]} knots
 * @param {number} parts
 * @returns {number[][]} x0, fx, fy, m and energy.
 */
function samples(branch, knots, parts) {
  const { rod } = branch;
  const rows = [];
  for (let i = 1; i < knots.length; i += 1) {
    if (knots[i].step === 0) continue;
    for (let k = 0; k < parts; k += 1) {
      const unknowns = between(knots[i - 1], knots[i], k / parts);
      const { offset, fx, fy, m } = rod.state(unknowns, knots[i - 1].state.contact);
      rows.push([branch.x1 - offset, fx, fy, m, rod.energyOf(unknowns)]);
    }
  }
  const { state } = knots[knots.length - 1];
  const x0 = displacement(branch, state);
  rows.push([x0, state.fx, state.fy, state.m, rod.energyOf(state.unknowns)]);
  return rows;
}
