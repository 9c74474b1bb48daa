// The equations of one rod in contact, and Newton's iteration for them: docs/model.md, (E1) to (E4).

import {
  arcDensity,
  arcGrowth,
  bendingCoordinate,
  compliance,
  complianceGrowths,
  compliances,
} from "./cone.js";
import { factorised, solved } from "./linear.js";
import { gaussRule, legendre, legendreIntegrals } from "./spectral.js";

/** Slope of the rod at its clamp. */
const CLAMP_SLOPE = Math.PI / 2;
const MOST_ITERATIONS = 14;
/** The next correction, as small as the last two let expect, that is not needed. */
const LAST_CORRECTION = 1e-12;
/** A correction of an angle larger than this leads away. */
const LARGEST_CORRECTION = 4;
/** A correction this much smaller than the one before was found with a Jacobian that still serves. */
const GOOD_CONTRACTION = 0.1;

/** @import { Factors } from "./linear.js" */

/**
 * How the rod touches the surface: with its tip, or along a line.
 *
 * @typedef {"point" | "line"} Contact
 */

/**
 * A solved state: lengths in units of L, forces of E·I0/L², moments of E·I0/L, angles in rad.
 *
 * @typedef {object} State
 * @property {Float64Array} unknowns Slopes at the nodes, then fx, fy and s_c.
 * @property {Contact} contact
 * @property {number} offset Position of the tip along the surface, seen from the clamp.
 * @property {number} fx
 * @property {number} fy
 * @property {number} m Moment at the clamp.
 * @property {number} phi1 Slope at the contact point.
 * @property {number} sc Arc length of the contact point.
 */

/**
 * The condition E3, linear in what it prescribes; what is not named has no part in it.
 *
 * @typedef {object} Condition
 * @property {number} [offset]
 * @property {number} [fx]
 * @property {number} [fy]
 * @property {number} [sc]
 * @property {number} [phi1]
 * @property {number} value
 */

/**
 * What a state is made of at the nodes.
 *
 * @typedef {object} Parts
 * @property {Float64Array} kernel
 * @property {Float64Array} arc ds/dτ.
 * @property {Float64Array} sin
 * @property {Float64Array} cos
 * @property {Float64Array} gradient dm/dτ.
 * @property {Float64Array} turned Slope that the moment takes from the rod; last at the contact point.
 * @property {number} height
 * @property {number} reach
 */

/** A tapered rod: its equations on a number of nodes. */
export class Rod {
  /**
   * @param {number} theta Taper factor.
   * @param {number} nodes
   */
  constructor(theta, nodes) {
    this.theta = theta;
    this.nodes = nodes;
    this.rule = gaussRule(nodes);
    this.tipKernel = this.kernel(compliances(theta, 1));
  }

  /**
   * Matrix of the double integral in (E1) with factors of the powers of τ in the compliance.
   *
   * @param {number[]} factors
   * @returns {Float64Array}
   */
  kernel(factors) {
    const [k0, k1, k2] = this.rule.kernels;
    const [a, b, c] = factors;
    const sum = new Float64Array(k0.length);
    for (let i = 0; i < sum.length; i += 1) sum[i] = a * k0[i] + b * k1[i] + c * k2[i];
    return sum;
  }

  /**
   * @param {Float64Array} unknowns
   * @returns {Parts}
   */
  parts(unknowns) {
    const { nodes: count, rule, theta } = this;
    const fx = unknowns[count];
    const fy = unknowns[count + 1];
    const sc = unknowns[count + 2];
    const kernel = sc === 1 ? this.tipKernel : this.kernel(compliances(theta, sc));
    const arc = new Float64Array(count);
    const sin = new Float64Array(count);
    const cos = new Float64Array(count);
    const gradient = new Float64Array(count);
    let height = 0;
    let reach = 0;
    for (let i = 0; i < count; i += 1) {
      arc[i] = arcDensity(theta, sc, rule.nodes[i]);
      sin[i] = Math.sin(unknowns[i]);
      cos[i] = Math.cos(unknowns[i]);
      gradient[i] = arc[i] * (fx * sin[i] - fy * cos[i]);
      height += rule.weights[i] * arc[i] * sin[i];
      reach += rule.weights[i] * arc[i] * cos[i];
    }
    return { kernel, arc, sin, cos, gradient, turned: product(kernel, gradient), height, reach };
  }

  /**
   * @param {Float64Array} unknowns
   * @param {Contact} contact
   * @returns {State}
   */
  state(unknowns, contact) {
    const { gradient, turned, reach } = this.parts(unknowns);
    const [fx, fy, sc] = unknowns.subarray(this.nodes);
    let m = 0;
    for (let i = 0; i < this.nodes; i += 1) m -= this.rule.weights[i] * gradient[i];
    const phi1 = contact === "line" ? 0 : CLAMP_SLOPE - turned[this.nodes];
    return { unknowns, contact, offset: reach + 1 - sc, fx, fy, m, phi1, sc };
  }

  /**
   * Residuals of (E1) to (E4).
   *
   * @param {Parts} parts
   * @param {Float64Array} unknowns
   * @param {number} eta Height of the contact point.
   * @param {Contact} contact
   * @param {Condition} condition
   * @returns {Float64Array}
   */
  residual({ turned, height, reach }, unknowns, eta, contact, condition) {
    const count = this.nodes;
    const residual = new Float64Array(count + 3);
    for (let i = 0; i < count; i += 1) residual[i] = unknowns[i] - CLAMP_SLOPE + turned[i];
    const phi1 = CLAMP_SLOPE - turned[count];
    const sc = unknowns[count + 2];
    const { offset = 0, fx = 0, fy = 0, sc: ofSc = 0, phi1: ofPhi1 = 0, value } = condition;
    residual[count] = height - eta;
    residual[count + 1] =
      offset * (reach + 1 - sc) +
      fx * unknowns[count] +
      fy * unknowns[count + 1] +
      ofSc * sc +
      ofPhi1 * phi1 -
      value;
    residual[count + 2] = contact === "line" ? phi1 : sc - 1;
    return residual;
  }

  /**
   * Factors of the residuals' Jacobian.
   *
   * @param {Parts} parts
   * @param {Float64Array} unknowns
   * @param {Contact} contact
   * @param {Condition} condition
   * @returns {Factors}
   */
  jacobian({ kernel, arc, sin, cos, gradient }, unknowns, contact, condition) {
    const { nodes: count, rule, theta } = this;
    const size = count + 3;
    const fx = unknowns[count];
    const fy = unknowns[count + 1];
    const sc = unknowns[count + 2];
    const rows = new Float64Array(size * size);
    // Slopes at the nodes and, one row more, at the contact point: E1.
    const ofTurned = new Float64Array(size);
    const lies = contact === "line";
    const ofSc = lies ? this.turnedGrowth(sc, arc, gradient, kernel) : null;
    const stiffness = new Float64Array(count);
    for (let k = 0; k < count; k += 1) stiffness[k] = arc[k] * (fx * cos[k] + fy * sin[k]);
    for (let i = 0; i <= count; i += 1) {
      const row = i < count ? rows : ofTurned;
      const start = i < count ? i * size : 0;
      let ofFx = 0;
      let ofFy = 0;
      for (let k = 0; k < count; k += 1) {
        const weight = kernel[i * count + k];
        row[start + k] = weight * stiffness[k];
        ofFx += weight * arc[k] * sin[k];
        ofFy -= weight * arc[k] * cos[k];
      }
      row[start + count] = ofFx;
      row[start + count + 1] = ofFy;
      if (ofSc) row[start + count + 2] = ofSc[i];
      if (i < count) row[start + i] += 1;
    }
    const e2 = count * size;
    const e3 = e2 + size;
    const e4 = e3 + size;
    const { offset = 0, phi1 = 0 } = condition;
    for (let k = 0; k < count; k += 1) {
      const weight = rule.weights[k] * arc[k];
      rows[e2 + k] = weight * cos[k];
      rows[e3 + k] = -offset * weight * sin[k];
      if (!lies) continue;
      const growth = weight * arcGrowth(theta, sc, rule.nodes[k]);
      rows[e2 + count + 2] += growth * sin[k];
      rows[e3 + count + 2] += offset * growth * cos[k];
    }
    rows[e3 + count] += condition.fx ?? 0;
    rows[e3 + count + 1] += condition.fy ?? 0;
    rows[e3 + count + 2] += (condition.sc ?? 0) - offset;
    for (let k = 0; k < size; k += 1) {
      rows[e3 + k] -= phi1 * ofTurned[k];
      if (lies) rows[e4 + k] = -ofTurned[k];
    }
    if (!lies) rows[e4 + count + 2] = 1;
    return factorised(rows, size);
  }

  /**
   * Derivative of `turned` with respect to s_c.
   *
   * @param {number} sc
   * @param {Float64Array} arc
   * @param {Float64Array} gradient
   * @param {Float64Array} kernel
   * @returns {Float64Array}
   */
  turnedGrowth(sc, arc, gradient, kernel) {
    const { theta, rule } = this;
    const grown = gradient.map((value, k) => value * arcGrowth(theta, sc, rule.nodes[k]));
    const sum = product(kernel, grown);
    const factors = complianceGrowths(theta, sc);
    for (let power = 0; power < factors.length; power += 1) {
      const part = product(rule.kernels[power], gradient);
      for (let i = 0; i < sum.length; i += 1) sum[i] += factors[power] * part[i];
    }
    return sum;
  }

  /**
   * Newton's iteration, with one Jacobian for several corrections where they shrink fast.
   *
   * @param {Float64Array} guess
   * @param {number} eta
   * @param {Contact} contact
   * @param {Condition} condition
   * @param {Factors | null} [near] Factors of the Jacobian in a state nearby.
   * @returns {State | null} null where it does not converge.
   */
  solve(guess, eta, contact, condition, near = null) {
    const unknowns = guess.slice();
    const size = this.nodes + 3;
    if (contact === "point") unknowns[size - 1] = 1;
    let factors = near;
    let before = 0;
    for (let step = 0; step < MOST_ITERATIONS; step += 1) {
      const parts = this.parts(unknowns);
      factors ??= this.jacobian(parts, unknowns, contact, condition);
      const change = solved(factors, this.residual(parts, unknowns, eta, contact, condition));
      const largest = corrected(unknowns, change);
      if (!(largest < LARGEST_CORRECTION) || !(unknowns[size - 1] > 0)) return null;
      if (contact === "point") unknowns[size - 1] = 1;
      // Factors from elsewhere tell nothing of the next correction yet; Newton's own square it.
      const contraction = step > 0 ? largest / before : near ? 1 : largest;
      if (largest * Math.min(1, contraction) < LAST_CORRECTION) return this.state(unknowns, contact);
      if (contraction > GOOD_CONTRACTION && (step > 0 || !near)) factors = null;
      before = largest;
    }
    return null;
  }

  /**
   * Derivative of a state with respect to what a condition prescribes.
   *
   * @param {State} state
   * @param {Condition} condition
   * @returns {{ change: Float64Array, factors: Factors }} Of the unknowns, and the Jacobian's factors.
   */
  tangent({ unknowns, contact }, condition) {
    const right = new Float64Array(this.nodes + 3);
    right[this.nodes + 1] = 1;
    const factors = this.jacobian(this.parts(unknowns), unknowns, contact, condition);
    return { change: solved(factors, right), factors };
  }

  /**
   * Derivative of the offset along a change of the unknowns.
   *
   * @param {State} state
   * @param {Float64Array} change
   * @returns {number}
   */
  offsetChange(state, change) {
    const { rule, theta, nodes: count } = this;
    const [sc, ofSc] = [state.sc, change[count + 2]];
    let sum = -ofSc;
    for (let k = 0; k < count; k += 1) {
      const phi = state.unknowns[k];
      const growth = ofSc === 0 ? 0 : ofSc * arcGrowth(theta, sc, rule.nodes[k]);
      const weight = rule.weights[k] * arcDensity(theta, sc, rule.nodes[k]);
      sum += weight * (growth * Math.cos(phi) - change[k] * Math.sin(phi));
    }
    return sum;
  }

  /**
   * Bending moments at the nodes.
   *
   * @param {Float64Array} unknowns
   * @returns {Float64Array}
   */
  moments(unknowns) {
    const { gradient } = this.parts(unknowns);
    const { fromStart, weights } = this.rule;
    const count = this.nodes;
    return weights.map((_, i) => {
      let m = 0;
      for (let k = 0; k < count; k += 1) {
        m -= (weights[k] - fromStart[i * count + k]) * gradient[k];
      }
      return m;
    });
  }

  /**
   * Bending energy, in units of E·I0/L.
   *
   * @param {Float64Array} unknowns
   * @returns {number}
   */
  energyOf(unknowns) {
    const { nodes, weights } = this.rule;
    const sc = unknowns[this.nodes + 2];
    return this.moments(unknowns).reduce(
      (sum, m, i) => sum + 0.5 * weights[i] * m * m * compliance(this.theta, sc, nodes[i]),
      0,
    );
  }

  /**
   * The deformed rod at equally spaced arc lengths, with its clamp at the origin.
   *
   * @param {State} state
   * @param {number} points
   * @returns {{ s: Float64Array, x: Float64Array, y: Float64Array, phi: Float64Array }}
   */
  shape(state, points) {
    const { nodes: count, theta, rule } = this;
    const { arc, sin, cos } = this.parts(state.unknowns);
    const phi = product(rule.toCoefficients, state.unknowns.subarray(0, count));
    const along = product(rule.toCoefficients, arc.map((a, k) => a * cos[k]));
    const up = product(rule.toCoefficients, arc.map((a, k) => a * sin[k]));
    const [s, x, y, slope] = [0, 1, 2, 3].map(() => new Float64Array(points));
    for (let i = 0; i < points; i += 1) {
      s[i] = i / (points - 1);
      const free = Math.min(s[i], state.sc);
      const at = bendingCoordinate(theta, state.sc, free);
      const values = legendre(count, at);
      const integrals = legendreIntegrals(values, at);
      x[i] = s[i] - free;
      for (let k = 0; k < count; k += 1) {
        x[i] += along[k] * integrals[k];
        y[i] += up[k] * integrals[k];
        slope[i] += phi[k] * values[k];
      }
    }
    return { s, x, y, phi: slope };
  }

  /**
   * Size of the last coefficients of the slope, relative to the largest: whether the nodes suffice.
   *
   * @param {State} state
   * @returns {number}
   */
  decay(state) {
    const coefficients = product(
      this.rule.toCoefficients,
      state.unknowns.subarray(0, this.nodes),
    ).map(Math.abs);
    const last = Math.max(...coefficients.subarray(this.nodes - 2));
    return last / Math.max(...coefficients);
  }
}

/**
 * Subtract a correction.
 *
 * @param {Float64Array} unknowns
 * @param {Float64Array} change
 * @returns {number} The largest change, of a slope (rad), of a force relative to it, or of s_c.
 */
function corrected(unknowns, change) {
  const size = unknowns.length;
  const scale = 1 / (1 + Math.abs(unknowns[size - 3]) + Math.abs(unknowns[size - 2]));
  let largest = 0;
  for (let i = 0; i < size; i += 1) {
    unknowns[i] -= change[i];
    const part = Math.abs(change[i]) * (i === size - 3 || i === size - 2 ? scale : 1);
    if (!(part <= largest)) largest = part;
  }
  return largest;
}

/**
 * Magnitude of the contact force.
 *
 * @param {State} state
 * @returns {number}
 */
export function force(state) {
  return Math.hypot(state.fx, state.fy);
}

/**
 * Inclination α of the contact force.
 *
 * @param {State} state
 * @returns {number}
 */
export function inclination(state) {
  return Math.atan2(state.fx, -state.fy);
}

/**
 * Friction coefficient −tan α that the tip needs to stick; negative where the clamp pulls.
 *
 * @param {State} state
 * @returns {number}
 */
export function demand(state) {
  return state.fx / state.fy;
}

/**
 * Product of a matrix, row by row, and a vector.
 *
 * @param {Float64Array} matrix
 * @param {Float64Array} vector
 * @returns {Float64Array}
 */
function product(matrix, vector) {
  const count = vector.length;
  const result = new Float64Array(matrix.length / count);
  for (let i = 0; i < result.length; i += 1) {
    let sum = 0;
    for (let k = 0; k < count; k += 1) sum += matrix[i * count + k] * vector[k];
    result[i] = sum;
  }
  return result;
}
