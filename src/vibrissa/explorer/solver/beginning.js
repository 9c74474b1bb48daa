// The state in which sticking begins: the buckled rod under a vertical force, α = 0.

import { gaussRule } from "./spectral.js";
import { bracketedRoot } from "./roots.js";

/** @import { Contact, Rod, State } from "./equilibrium.js" */

/** Heights near 1, where the rod is nearly straight, from which a low surface is approached. */
const HIGHEST = 0.99;
/** Largest step of √(1 − η), with which the deflection grows. */
const LARGEST_STEP = 0.09;
const VERTICAL = { fx: 1, value: 0 };

/**
 * Solve the first-mode state that is bent towards +x.
 *
 * @param {Rod} rod
 * @param {number} eta
 * @param {Contact} model "point": with the tip alone; "line": with the contact that is possible.
 * @returns {State | null}
 */
export function firstState(rod, eta, model) {
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
 * @param {State | null} before
 * @param {State} state
 * @returns {Float64Array}
 */
function ahead(before, state) {
  if (!before) return state.unknowns;
  return state.unknowns.map((value, i) => 2 * value - before.unknowns[i]);
}

/**
 * @param {Rod} rod
 * @param {Float64Array} guess
 * @param {number} eta
 * @param {Contact} contact The kind of contact to try first.
 * @param {Contact} model
 * @returns {State | null}
 */
function solvedActive(rod, guess, eta, contact, model) {
  const state = rod.solve(guess, eta, contact, VERTICAL);
  if (model === "point" || (state && isPossible(state))) return state;
  const other = rod.solve(
    touching(state ? state.unknowns : guess),
    eta,
    contact === "line" ? "point" : "line",
    VERTICAL,
  );
  return other && isPossible(other) ? other : null;
}

/**
 * @param {Float64Array} unknowns
 * @returns {Float64Array} The same, touching with the tip.
 */
function touching(unknowns) {
  const changed = unknowns.slice();
  changed[changed.length - 1] = 1;
  return changed;
}

/**
 * Whether the kind of contact can be as it is: a tip from below, a line up to the tip.
 *
 * @param {State} state
 * @returns {boolean}
 */
export function isPossible(state) {
  return state.contact === "line" ? state.sc <= 1 : state.phi1 >= 0;
}

/**
 * @param {Rod} rod
 * @param {State} state
 * @returns {boolean} Whether the rod is bent to one side throughout, and pressed.
 */
function isFirstMode(rod, state) {
  return state.fy < 0 && rod.moments(state.unknowns).every((m) => m < 0);
}

/**
 * The buckling mode (6), scaled to the height.
 *
 * @param {Rod} rod
 * @param {number} eta
 * @returns {Float64Array}
 */
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
  unknowns.set(mode.map((value) => Math.PI / 2 + amplitude * value));
  unknowns.set([0, -((kappa / theta) ** 2), 1], count);
  return unknowns;
}
