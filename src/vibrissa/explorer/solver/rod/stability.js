// Whether a state is a minimum of the energy: in its plane, and out of it.

import { compliance } from "./cone.js";
import { CLAMP_SLOPE, naturalCurvature } from "./mounting.js";
import { determinant, factorised, isPositive } from "../numerics/linear.js";

/** @import { Rod } from "./rod.js" */
/** @import { State } from "./state.js" */

/** Stiffness that stands for a rigid constraint. */
const RIGID = 1e8;
/** Poisson's ratio: bending over torsional stiffness of a round section is 1 more. */
const POISSON = 0.3;

/**
 * Whether a tip that slides without friction would stay: (M8) of docs/mounting.md is positive with
 * the height alone held.
 *
 * @param {Rod} rod
 * @param {State} state
 * @returns {boolean}
 */
export function slidesStably(rod, state) {
  const { nodes: count, rule, mounting } = rod;
  const { sin, cos, arc } = rod.parts(state.unknowns);
  // One variable for each node, the root of its bending energy, and one for the turn of the clamp.
  const size = count + 1;
  const root = new Float64Array(size);
  const slope = new Float64Array(count * size);
  for (let k = 0; k < count; k += 1) {
    root[k] = Math.sqrt(rule.weights[k] * compliance(rod.theta, state.sc, rule.nodes[k]));
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

/**
 * Stiffness against a turn at the contact point of a rod that lies on the surface.
 *
 * @param {Rod} rod
 * @param {State} state
 * @returns {number}
 */
function touchStiffness({ mounting }, { fy, sc }) {
  const curvature = naturalCurvature(mounting, sc);
  return curvature < 0 ? Math.min(RIGID, Math.max(0, fy / curvature)) : RIGID;
}

/**
 * A symmetric matrix among vectors that are normal to another, and 1 along that one.
 *
 * @param {Float64Array} matrix
 * @param {Float64Array} normal
 * @returns {Float64Array}
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
 * Positive where a round rod stays in its plane, zero where it swings aside: the determinant of the
 * second variation (D1) of docs/aside.md among shapes that keep the contact point in the plane.
 *
 * @param {Rod} rod
 * @param {State} state
 * @returns {number}
 */
export function marginAside(rod, state) {
  const variation = new Variation(rod, state);
  const { size, held } = variation;
  const border = size + 1;
  const matrix = new Float64Array(border * border);
  const unit = new Float64Array(size);
  for (let column = 0; column < size; column += 1) {
    unit[column] = 1;
    const image = variation.image(unit);
    unit[column] = 0;
    for (let row = 0; row < size; row += 1) {
      matrix[row * border + column] = image[row] + (row === column ? 1 : 0);
    }
    matrix[size * border + column] = held[column];
    matrix[column * border + size] = held[column];
  }
  return -determinant(factorised(matrix, border));
}

/** The part of (D1) that is not elastic energy, on the roots of the energies of twist and bend. */
class Variation {
  /**
   * @param {Rod} rod
   * @param {State} state
   */
  constructor(rod, state) {
    const { nodes: count, rule } = rod;
    const { sin, cos, arc } = rod.parts(state.unknowns);
    this.count = count;
    /** Twists, bends, and the turn of the clamp. */
    this.size = 2 * count + 1;
    this.sin = sin;
    this.cos = cos;
    this.rule = rule;
    this.half = rod.moments(state.unknowns).map((m) => 0.5 * m);
    const length = arc.map((value, k) => value * rule.weights[k]);
    this.bend = rule.nodes.map((tau, k) =>
      Math.sqrt(rule.weights[k] * compliance(rod.theta, state.sc, tau)),
    );
    this.twist = this.bend.map((value) => Math.sqrt(1 + POISSON) * value);
    const { fx, fy } = state;
    this.pull = length.map((value, k) => value * (fx * cos[k] + fy * sin[k]));
    this.shear = length.map((value, k) => 0.5 * value * (fy * cos[k] - fx * sin[k]));
    this.clamp = clampTurn(rod, state.m);
    const moved = this.transposed(new Float64Array(count), length);
    const norm = Math.hypot(...moved);
    /** Direction that moves the contact point out of the plane (D2). */
    this.held = moved.map((value) => value / norm);
  }

  /**
   * @param {Float64Array} u
   * @returns {Float64Array}
   */
  image(u) {
    const { count, sin, cos, half, twist, bend, pull, shear, rule, clamp } = this;
    const [along, across] = [new Float64Array(count), new Float64Array(count)];
    const [turned, bent] = [new Float64Array(count), new Float64Array(count)];
    const [ofX, ofY] = [new Float64Array(count), new Float64Array(count)];
    for (let k = 0; k < count; k += 1) {
      [turned[k], bent[k]] = [twist[k] * u[k], bend[k] * u[count + k]];
      ofX[k] = (cos[k] * turned[k] - sin[k] * bent[k]) / rule.weights[k];
      ofY[k] = (sin[k] * turned[k] + cos[k] * bent[k]) / rule.weights[k];
    }
    for (let i = 0; i < count; i += 1) {
      let [x, y] = [clamp[0] * u[2 * count], clamp[1] * u[2 * count]];
      for (let k = 0; k < count; k += 1) {
        x += rule.fromStart[i * count + k] * ofX[k];
        y += rule.fromStart[i * count + k] * ofY[k];
      }
      along[i] = cos[i] * x + sin[i] * y;
      across[i] = cos[i] * y - sin[i] * x;
    }
    const image = this.transposed(
      across.map((value, k) => -half[k] * bent[k] - shear[k] * value),
      across.map((value, k) => half[k] * turned[k] + pull[k] * value - shear[k] * along[k]),
    );
    for (let k = 0; k < count; k += 1) {
      image[k] += twist[k] * half[k] * across[k];
      image[count + k] -= bend[k] * half[k] * along[k];
    }
    return image;
  }

  /**
   * Transpose of the map from the variables to rotations along the rod and across it.
   *
   * @param {Float64Array} along
   * @param {Float64Array} across
   * @returns {Float64Array}
   */
  transposed(along, across) {
    const { count, sin, cos, twist, bend, rule, clamp } = this;
    const result = new Float64Array(this.size);
    const [ofX, ofY] = [new Float64Array(count), new Float64Array(count)];
    for (let i = 0; i < count; i += 1) {
      const x = cos[i] * along[i] - sin[i] * across[i];
      const y = sin[i] * along[i] + cos[i] * across[i];
      result[2 * count] += clamp[0] * x + clamp[1] * y;
      for (let k = 0; k < count; k += 1) {
        ofX[k] += rule.fromStart[i * count + k] * x;
        ofY[k] += rule.fromStart[i * count + k] * y;
      }
    }
    for (let k = 0; k < count; k += 1) {
      const weight = 1 / rule.weights[k];
      result[k] = twist[k] * weight * (cos[k] * ofX[k] + sin[k] * ofY[k]);
      result[count + k] = bend[k] * weight * (cos[k] * ofY[k] - sin[k] * ofX[k]);
    }
    return result;
  }
}

/**
 * Rotation of a yielding clamp whose energy grows by 1/2, as (D9) has it.
 *
 * @param {Rod} rod
 * @param {number} m Moment at the clamp.
 * @returns {[number, number]}
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
