// Newton's iteration for one state: residuals of (E1) to (E4) of docs/model.md and their Jacobian.

import { arcGrowth, arcLengthGrowth, arcLength } from "./cone.js";
import { isStraight, naturalCurvature } from "./mounting.js";
import { factorised, product, solved } from "../numerics/linear.js";

const MOST_ITERATIONS = 14;
/** Size that the last two corrections predict for the next one, below which it is not needed (rad for angles). */
const LAST_CORRECTION = 1e-12;
/** Largest correction; a larger one means divergence (rad for angles). */
const LARGEST_CORRECTION = 4;
/** Ratio of a correction to the one before up to which the Jacobian is used again. */
const GOOD_CONTRACTION = 0.1;

/** Residuals (E1) to (E4). @type {(parts: NodeValues, unknowns: Float64Array, closure: Closure) => Float64Array} */
function residualOf({ natural, turned, height, reach }, unknowns, { surface, contact, condition }) {
  const count = turned.length - 1;
  const residual = new Float64Array(count + 3);
  for (let i = 0; i < count; i += 1) residual[i] = unknowns[i] - natural[i] + turned[i];
  const phi1 = natural[count] - turned[count];
  const sc = unknowns[count + 2];
  const { offset = 0, fx = 0, fy = 0, sc: ofSc = 0, phi1: ofPhi1 = 0, value } = condition;
  residual[count] = height - surface.tilt * (reach + 1 - sc) - surface.level;
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
 * @type {(rod: Rod, parts: NodeValues, unknowns: Float64Array, closure: Closure) => Factors}
 */
function jacobian(rod, parts, unknowns, { surface, contact, condition }) {
  const { arc, sin, cos } = parts;
  const { nodes: count, rule, theta } = rod;
  const [size, sc, lies] = [count + 3, unknowns[count + 2], contact === "line"];
  const rows = new Float64Array(size * size);
  const turned = turnedChange(rod, parts, unknowns, lies);
  const ofTurned = turned.subarray(count * size);
  rows.set(turned.subarray(0, count * size));
  for (let i = 0; i < count; i += 1) rows[i * size + i] += 1;
  const [e2, e3, e4] = [count * size, (count + 1) * size, (count + 2) * size];
  const { offset = 0, phi1 = 0 } = condition;
  for (let k = 0; k < count; k += 1) {
    const weight = rule.weights[k] * arc[k];
    rows[e2 + k] = weight * (cos[k] + surface.tilt * sin[k]);
    rows[e3 + k] = -offset * weight * sin[k];
    if (!lies) continue;
    const growth = weight * arcGrowth(theta, sc, rule.nodes[k]);
    rows[e2 + count + 2] += growth * (sin[k] - surface.tilt * cos[k]);
    rows[e3 + count + 2] += offset * growth * cos[k];
  }
  rows[e2 + count + 2] += surface.tilt;
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
 * Derivatives of `turned` with respect to all unknowns: a row for each node and, last, for the contact point.
 * @type {(rod: Rod, parts: NodeValues, unknowns: Float64Array, lies: boolean) => Float64Array}
 */
function turnedChange(rod, parts, unknowns, lies) {
  const { kernel, arc, sin, cos } = parts;
  const [count, size] = [rod.nodes, rod.nodes + 3];
  const [fx, fy] = [unknowns[count], unknowns[count + 1]];
  const ofSc = lies ? turnedGrowth(rod, unknowns[count + 2], parts) : null;
  const rows = new Float64Array((count + 1) * size);
  const [byFx, byFy, stiffness] = [0, 0, 0].map(() => new Float64Array(count));
  for (let k = 0; k < count; k += 1) {
    byFx[k] = arc[k] * sin[k];
    byFy[k] = -arc[k] * cos[k];
    stiffness[k] = fx * -byFy[k] + fy * byFx[k];
  }
  for (let i = 0; i <= count; i += 1) {
    const start = i * size;
    let ofFx = 0;
    let ofFy = 0;
    for (let k = 0; k < count; k += 1) {
      const weight = kernel[i * count + k];
      rows[start + k] = weight * stiffness[k];
      ofFx += weight * byFx[k];
      ofFy += weight * byFy[k];
    }
    rows[start + count] = ofFx;
    rows[start + count + 1] = ofFy;
    if (ofSc) rows[start + count + 2] = ofSc[i];
  }
  return rows;
}

/**
 * Derivative of `turned`, less that of the natural slopes, with respect to s_c.
 * @type {(rod: Rod, sc: number, parts: NodeValues) => Float64Array}
 */
function turnedGrowth(rod, sc, { arc, gradient, kernel }) {
  const { theta, rule, mounting } = rod;
  const grown = gradient.map((value, k) => value * arcGrowth(theta, sc, rule.nodes[k]));
  const sum = product(kernel, grown);
  const part = product(rod.kernelGrowth(sc), gradient);
  for (let i = 0; i < sum.length; i += 1) sum[i] += part[i];
  for (let i = 0; i < sum.length && !isStraight(mounting); i += 1) {
    const tau = i < arc.length ? rule.nodes[i] : 1;
    const curvature = naturalCurvature(mounting, arcLength(theta, sc, tau));
    sum[i] -= curvature * arcLengthGrowth(theta, sc, tau);
  }
  return sum;
}

/**
 * Solve a state by Newton's iteration; corrections that shrink fast share one Jacobian. `near` are factors
 * of the Jacobian of a nearby state. Returns null if the iteration does not converge.
 * @type {(rod: Rod, guess: Float64Array, closure: Closure, near?: Factors | null, tolerance?: number)
 *   => State | null}
 */
export function solvedState(rod, guess, closure, near = null, tolerance = LAST_CORRECTION) {
  const { contact } = closure;
  const unknowns = guess.slice();
  const size = rod.nodes + 3;
  if (contact === "point") unknowns[size - 1] = 1;
  let factors = near;
  let before = 0;
  for (let step = 0; step < MOST_ITERATIONS; step += 1) {
    const parts = rod.parts(unknowns);
    factors ??= jacobian(rod, parts, unknowns, closure);
    const change = solved(factors, residualOf(parts, unknowns, closure));
    const largest = corrected(unknowns, change);
    if (!(largest < LARGEST_CORRECTION) || !(unknowns[size - 1] > 0)) return null;
    if (contact === "point") unknowns[size - 1] = 1;
    // With factors of another state, the first correction predicts nothing; with its own, the next is its square.
    const contraction = step > 0 ? largest / before : near ? 1 : largest;
    if (largest * Math.min(1, contraction) < tolerance) return rod.state(unknowns, contact);
    if (contraction > GOOD_CONTRACTION && (step > 0 || !near)) factors = null;
    before = largest;
  }
  return null;
}

/**
 * Derivative of the unknowns with respect to the value of a condition, and factors of the Jacobian.
 * @type {(rod: Rod, state: State, surface: Surface, condition: Condition)
 *   => { change: Float64Array, factors: Factors }}
 */
export function tangent(rod, { unknowns, contact }, surface, condition) {
  const right = new Float64Array(rod.nodes + 3);
  right[rod.nodes + 1] = 1;
  const closure = { surface, contact, condition };
  const factors = jacobian(rod, rod.parts(unknowns), unknowns, closure);
  return { change: solved(factors, right), factors };
}

/**
 * Subtract a correction; returns its largest entry: of a slope (rad), of a relative force, or of s_c.
 * @type {(unknowns: Float64Array, change: Float64Array) => number}
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
