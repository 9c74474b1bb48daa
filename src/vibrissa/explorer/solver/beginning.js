// The state in which sticking begins: the buckled rod under a vertical force, α = 0.

import { bracketedRoot } from "./numerics/roots.js";
import { gaussRule } from "./numerics/spectral.js";
import { CLAMP_SLOPE, isIdealRod, isSolid, scaledMounting } from "./rod/mounting.js";
import { solvedState } from "./rod/newton.js";
import { Rod } from "./rod/rod.js";
import { slidesStably } from "./rod/stability.js";

/** Height near 1, where the rod is nearly straight, from which lower surfaces are approached. */
const HIGHEST = 0.99;
/** Largest step of √(1 − η), to which the deflection is nearly proportional. */
const LARGEST_STEP = 0.09;
const VERTICAL = { fx: 1, value: 0 };
/** Largest difference between a state and its guess, relative to the rod's bend; beyond is another branch. */
const CLOSE = 0.3;
/** Divisor of a step of the homotopy that fails, and shortest step. */
const DIVISION = 4;
const SHORTEST_PART = 1e-4;

/**
 * Solve the first state of a period of sticking. Returns a message if none exists, empty if none was found.
 * With the model "point" only the tip touches; with "line" the rod may lie on the surface.
 * @type {(rod: Rod, eta: number, model: Contact) => Beginning | string}
 */
export function beginningOf(rod, eta, model) {
  const ideal = firstState(new Rod(rod.theta, rod.nodes), eta, model);
  if (!ideal) return "";
  if (isIdealRod(rod.mounting) && isSolid(rod.mounting)) return { state: ideal, ideal };
  const state = mountedState(rod, ideal, eta, model);
  return typeof state === "string" ? state : { state, ideal };
}

/**
 * Follow a first state from the ideal mounting to the rod's mounting; all deviations grow in proportion.
 * @type {(rod: Rod, ideal: State, eta: number, model: Contact) => State | string}
 */
function mountedState({ theta, nodes, mounting }, ideal, eta, model) {
  /** @type {Partly[]} */
  let known = [{ state: ideal, share: 0 }];
  for (let step = 1; known[known.length - 1].share < 1; ) {
    const { state, share } = known[known.length - 1];
    const target = Math.min(1, share + step);
    const part = new Rod(theta, nodes, scaledMounting(mounting, target));
    const before = known.length > 1 ? known[0] : null;
    const weight = before ? (target - share) / (share - before.share) : 0;
    const guess = ahead(before && before.state, state, weight);
    const found = solvedActive(part, guess, eta, state.contact, model);
    if (found && isNear(found, guess, nodes) && slidesStably(part, found)) {
      if (found.fy >= 0) return "the rod does not press on the surface: try a smaller η";
      known = [{ state, share }, { state: found, share: target }];
      step *= 2;
    } else {
      step /= DIVISION;
      if (step < SHORTEST_PART) {
        return "the rod springs to the other side: try a smaller η, β or curvature";
      }
    }
  }
  return known[known.length - 1].state;
}

/**
 * Whether a state is on the branch of its guess.
 * @type {(state: State, guess: Float64Array, nodes: number) => boolean}
 */
function isNear(state, guess, nodes) {
  const slopes = state.unknowns.subarray(0, nodes);
  const missed = slopes.reduce((most, value, i) => Math.max(most, Math.abs(value - guess[i])), 0);
  return missed < CLOSE * (Math.max(...slopes) - Math.min(...slopes));
}

/** The first-mode state that is bent towards +x. @type {(rod: Rod, eta: number, model: Contact) => State | null} */
function firstState(rod, eta, model) {
  const low = Math.sqrt(1 - Math.max(eta, HIGHEST));
  const high = Math.sqrt(1 - eta);
  const count = Math.ceil((high - low) / LARGEST_STEP);
  /** @type {State | null} */
  let state = null;
  /** @type {State | null} */
  let before = null;
  for (let k = 0; k <= count; k += 1) {
    const height = 1 - (low + (count ? (k / count) * (high - low) : 0)) ** 2;
    const guess = state ? ahead(before, state) : buckled(rod, height);
    const found = solvedActive(rod, guess, height, state ? state.contact : "point", model);
    if (!found || !isFirstMode(rod, found)) return null;
    [before, state] = [state && state.contact === found.contact ? state : null, found];
  }
  return state;
}

/**
 * Extrapolate unknowns from two states: past the second by their difference times a weight.
 * @type {(before: State | null, state: State, weight?: number) => Float64Array}
 */
function ahead(before, state, weight = 1) {
  if (!before) return state.unknowns;
  return state.unknowns.map((value, i) => value + weight * (value - before.unknowns[i]));
}

/**
 * Solve a first state; `contact` is the kind of contact to try first.
 * @type {(rod: Rod, guess: Float64Array, eta: number, contact: Contact, model: Contact) => State | null}
 */
function solvedActive(rod, guess, eta, contact, model) {
  const closure = { surface: { level: eta, tilt: 0 }, condition: VERTICAL };
  const state = solvedState(rod, guess, { ...closure, contact });
  if (model === "point" || (state && isPossible(state))) return state;
  const other = solvedState(rod, touching(state ? state.unknowns : guess), {
    ...closure,
    contact: contact === "line" ? "point" : "line",
  });
  return other && isPossible(other) ? other : null;
}

/** Unknowns with the contact point moved to the tip. @type {(unknowns: Float64Array) => Float64Array} */
function touching(unknowns) {
  const changed = unknowns.slice();
  changed[changed.length - 1] = 1;
  return changed;
}

/** Whether the contact is possible: φ1 ≥ 0 of a tip, s_c ≤ 1 of a line. @type {(state: State) => boolean} */
export function isPossible(state) {
  return state.contact === "line" ? state.sc <= 1 : state.phi1 >= 0;
}

/** Whether the rod is bent to one side throughout, and pressed. @type {(rod: Rod, state: State) => boolean} */
function isFirstMode(rod, state) {
  return state.fy < 0 && rod.moments(state.unknowns).every((m) => m < 0);
}

/** The buckling mode (6), scaled to the height. @type {(rod: Rod, eta: number) => Float64Array} */
function buckled(rod, eta) {
  const { theta, nodes: count } = rod;
  const { nodes, weights } = gaussRule(count);
  /** @param {number} k */
  const condition = (k) => (theta - 1) * Math.sin(k) + k * Math.cos(k);
  const [low, high] = [Math.PI / 2, Math.PI];
  const kappa = bracketedRoot(condition, low, high, condition(low), condition(high), 1e-14);
  const mode = nodes.map((tau) => {
    const phase = kappa * (1 - tau);
    const diameter = kappa * (1 + (theta - 1) * tau);
    return -((theta - 1) * Math.sin(phase) + diameter * Math.cos(phase)) / (kappa * theta);
  });
  let square = 0;
  for (let k = 0; k < count; k += 1) {
    square += (weights[k] * theta * mode[k] ** 2) / (1 + (theta - 1) * nodes[k]) ** 2;
  }
  const amplitude = Math.sqrt((2 * (1 - eta)) / square);
  const unknowns = new Float64Array(count + 3);
  unknowns.set(mode.map((value) => CLAMP_SLOPE + amplitude * value));
  unknowns.set([0, -((kappa / theta) ** 2), 1], count);
  return unknowns;
}
