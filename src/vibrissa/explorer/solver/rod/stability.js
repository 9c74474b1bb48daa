// Whether a state is a minimum of the energy: in its plane, and out of it.

import { CLAMP_SLOPE, naturalCurvature } from "./mounting.js";
import { determinant, factorised, isPositive } from "../numerics/linear.js";

/** Stiffness that stands for a rigid constraint. */
const RIGID = 1e8;
/** Poisson's ratio: bending over torsional stiffness of a round section is 1 more. */
const POISSON = 0.3;

/**
 * Whether a state is stable if its tip slides without friction: (M8) of docs/mounting.md is positive
 * while only the height is held.
 * @type {(rod: Rod, state: State) => boolean}
 */
export function slidesStably(rod, state) {
  const { nodes: count, rule, mounting } = rod;
  const { sin, cos, arc } = rod.parts(state.unknowns);
  // Variables: the root of the bending energy at each node, and of the energy of the clamp's rotation.
  const size = count + 1;
  const root = new Float64Array(size);
  const slope = new Float64Array(count * size);
  for (let k = 0; k < count; k += 1) {
    root[k] = Math.sqrt(rule.weights[k] * rod.compliance(state.sc, rule.nodes[k]));
  }
  root[count] = Math.sqrt(mounting.compliance);
  const [load, held] = [new Float64Array(count), new Float64Array(size)];
  for (let i = 0; i < count; i += 1) {
    for (let k = 0; k < count; k += 1) {
      slope[i * size + k] = (rule.fromStart[i * count + k] / rule.weights[k]) * root[k];
    }
    slope[i * size + count] = root[count];
    const length = rule.weights[i] * arc[i];
    load[i] = length * (state.fx * cos[i] + state.fy * sin[i]);
    for (let k = 0; k < size; k += 1) held[k] += length * cos[i] * slope[i * size + k];
  }
  const stiffness = state.contact === "line" ? touchStiffness(rod, state) : 0;
  const matrix = new Float64Array(size * size);
  for (let a = 0; a < size; a += 1) {
    for (let b = 0; b < size; b += 1) {
      let sum = (a === b ? 1 : 0) + stiffness * root[a] * root[b];
      for (let i = 0; i < count; i += 1) sum += load[i] * slope[i * size + a] * slope[i * size + b];
      matrix[a * size + b] = sum;
    }
  }
  return isPositive(within(matrix, held), size);
}

/** Stiffness against rotation at the contact point in line contact. @type {(rod: Rod, state: State) => number} */
function touchStiffness({ mounting }, { fy, sc }) {
  const curvature = naturalCurvature(mounting, sc);
  return curvature < 0 ? Math.min(RIGID, Math.max(0, fy / curvature)) : RIGID;
}

/**
 * Restrict a symmetric matrix to vectors orthogonal to `normal`; along `normal` it is set to 1.
 * @type {(matrix: Float64Array, normal: Float64Array) => Float64Array}
 */
function within(matrix, normal) {
  const size = normal.length;
  const norm = Math.hypot(...normal);
  const h = normal.map((value) => value / norm);
  const image = h.map((_, a) => h.reduce((sum, value, b) => sum + matrix[a * size + b] * value, 0));
  const along = h.reduce((sum, value, a) => sum + value * image[a], 0);
  return matrix.map((value, place) => {
    const [a, b] = [Math.floor(place / size), place % size];
    return value - h[a] * image[b] - image[a] * h[b] + (along + 1) * h[a] * h[b];
  });
}

/**
 * Determinant of the second variation (D1) of docs/lateral.md for shapes that keep the contact point in the
 * plane: positive where a round rod stays in its plane, zero where it buckles laterally.
 *
 * Variables are the roots of the energies of twist and bending at the nodes, and of the clamp's rotation:
 * the matrix of the elastic energy is then the unit matrix.
 * @type {(rod: Rod, state: State) => number}
 */
export function lateralMargin(rod, state) {
  const { nodes: count, rule } = rod;
  const { sin, cos, arc } = rod.parts(state.unknowns);
  const { along, across, twist, bend } = rotations(rod, state, sin, cos);
  const size = 2 * count + 1;
  const border = size + 1;
  const matrix = new Float64Array(border * border);
  const half = rod.moments(state.unknowns).map((m) => 0.5 * m);
  const held = new Float64Array(size);
  const mixed = new Float64Array(size);
  for (let i = 0; i < count; i += 1) {
    const length = rule.weights[i] * arc[i];
    const pull = 0.5 * length * (state.fx * cos[i] + state.fy * sin[i]);
    const shear = 0.5 * length * (state.fy * cos[i] - state.fx * sin[i]);
    const row = i * size;
    for (let k = 0; k < size; k += 1) {
      held[k] += length * across[row + k];
      mixed[k] = pull * across[row + k] - shear * along[row + k];
    }
    mixed[i] += half[i] * twist[i];
    for (let a = 0; a < size; a += 1) {
      const [c, g] = [across[row + a], mixed[a]];
      for (let b = 0; b < size; b += 1) {
        matrix[a * border + b] += c * mixed[b] + g * across[row + b];
      }
      const bent = half[i] * bend[i] * along[row + a];
      matrix[a * border + count + i] -= bent;
      matrix[(count + i) * border + a] -= bent;
    }
  }
  const norm = Math.hypot(...held);
  for (let k = 0; k < size; k += 1) {
    matrix[k * border + k] += 1;
    matrix[k * border + size] = held[k] / norm;
    matrix[size * border + k] = held[k] / norm;
  }
  return -determinant(factorised(matrix, border));
}

/**
 * Rotations ω at the nodes (rows) for each variable (columns), along the rod and across it in its plane;
 * and ω' for each variable of twist and bending, times the weights of the nodes.
 * @type {(rod: Rod, state: State, sin: Float64Array, cos: Float64Array)
 *   => Record<"along" | "across" | "twist" | "bend", Float64Array>}
 */
function rotations(rod, state, sin, cos) {
  const { nodes: count, rule } = rod;
  const size = 2 * count + 1;
  const [along, across] = [new Float64Array(count * size), new Float64Array(count * size)];
  const bend = rule.nodes.map((tau, k) => Math.sqrt(rule.weights[k] * rod.compliance(state.sc, tau)));
  const twist = bend.map((value) => Math.sqrt(1 + POISSON) * value);
  const [x, y] = clampTurn(rod, state.m);
  for (let i = 0; i < count; i += 1) {
    const row = i * size;
    for (let k = 0; k < count; k += 1) {
      const integral = rule.fromStart[i * count + k] / rule.weights[k];
      const near = integral * (cos[i] * cos[k] + sin[i] * sin[k]);
      const aside = integral * (cos[i] * sin[k] - sin[i] * cos[k]);
      along[row + k] = twist[k] * near;
      across[row + k] = twist[k] * aside;
      along[row + count + k] = -bend[k] * aside;
      across[row + count + k] = bend[k] * near;
    }
    along[row + 2 * count] = cos[i] * x + sin[i] * y;
    across[row + 2 * count] = cos[i] * y - sin[i] * x;
  }
  return { along, across, twist, bend };
}

/**
 * Rotation ω(0) of a yielding clamp with the moment m, for a variable of 1: (D9) of docs/lateral.md.
 * @type {(rod: Rod, m: number) => [number, number]}
 */
function clampTurn({ mounting }, m) {
  const axis = CLAMP_SLOPE + mounting.angle;
  const turn = mounting.compliance * m;
  const across = turn === 0 ? 1 : Math.sin(turn) / turn;
  const along = turn === 0 ? 0 : (1 - Math.cos(turn)) / turn;
  const q = Math.sqrt(mounting.compliance / across);
  return [
    q * (-across * Math.sin(axis) - along * Math.cos(axis)),
    q * (across * Math.cos(axis) - along * Math.sin(axis)),
  ];
}
