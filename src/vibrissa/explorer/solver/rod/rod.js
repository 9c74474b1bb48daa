// A tapered rod: its shape and forces on a number of nodes, (E1) to (E4) of docs/model.md.

import {
  arcDensity,
  arcGrowth,
  arcLength,
  arcLengthGrowth,
  bendingCoordinate,
  compliance,
  complianceGrowths,
  compliances,
  stiffnessFactor,
  stiffnessGrowth,
} from "./cone.js";
import { IDEAL, SOLID, isSolid, isStraight, naturalSlope, tailOf } from "./mounting.js";
import { product } from "../numerics/linear.js";
import { gaussRule, legendre, legendreIntegrals } from "../numerics/spectral.js";

/** Equations of a tapered rod on a number of nodes. */
export class Rod {
  /**
   * @param {number} theta Taper factor.
   * @param {number} nodes
   * @param {Mounting} [mounting]
   */
  constructor(theta, nodes, mounting = IDEAL) {
    this.theta = theta;
    this.nodes = nodes;
    this.mounting = mounting;
    this.rule = gaussRule(nodes);
    this.solid = isSolid(mounting);
    this.making = mounting.making ?? SOLID;
    this.tipKernel = this.kernel(1);
    this.straight = isStraight(mounting);
    this.tipSlopes = this.naturalSlopes(1);
    this.tipArc = this.arcs(1);
  }

  /** B⁻¹·ds/dτ. @type {(sc: number, tau: number) => number} */
  compliance(sc, tau) {
    const { theta, making } = this;
    const cone = compliance(theta, sc, tau);
    return this.solid ? cone : cone / stiffnessFactor(theta, making, arcLength(theta, sc, tau));
  }

  /**
   * Matrix of the double integral in (E1). A yielding clamp adds the matrix of c·m(0), an integral of the
   * same gradient.
   * @type {(sc: number) => Float64Array}
   */
  kernel(sc) {
    const sum = this.solid
      ? this.coneIntegral(compliances(this.theta, sc))
      : this.doubleIntegral(this.rule.nodes.map((tau) => this.compliance(sc, tau)));
    const turn = this.mounting.compliance;
    const { weights, count } = this.rule;
    return turn === 0 ? sum : sum.map((value, i) => value + turn * weights[i % count]);
  }

  /**
   * Matrix of the double integral of a solid cone, from the factors of 1, τ and τ² in its compliance.
   * @type {(factors: number[]) => Float64Array}
   */
  coneIntegral([a, b, c]) {
    const [k0, k1, k2] = this.rule.kernels;
    return k0.map((value, i) => a * value + b * k1[i] + c * k2[i]);
  }

  /**
   * Matrix of the double integral, from values that stand for the compliance at the nodes.
   * @type {(values: Float64Array) => Float64Array}
   */
  doubleIntegral(values) {
    const { count, weights, fromStart } = this.rule;
    const sum = new Float64Array((count + 1) * count);
    for (let i = 0; i <= count; i += 1) {
      for (let j = 0; j < count; j += 1) {
        const part = fromStart[i * count + j] * values[j];
        for (let k = 0; k < count; k += 1) sum[i * count + k] += part * (weights[k] - fromStart[j * count + k]);
      }
    }
    return sum;
  }

  /** Derivative by s_c of the matrix of the double integral. @type {(sc: number) => Float64Array} */
  kernelGrowth(sc) {
    const { theta, making, rule } = this;
    const [a, b, c] = complianceGrowths(theta, sc);
    if (this.solid) return this.coneIntegral([a, b, c]);
    const growths = rule.nodes.map((tau) => {
      const s = arcLength(theta, sc, tau);
      const cone = a + tau * (b + tau * c);
      const factor = stiffnessFactor(theta, making, s);
      const growth = stiffnessGrowth(theta, making, s) * arcLengthGrowth(theta, sc, tau);
      return cone / factor - this.compliance(sc, tau) * growth;
    });
    return this.doubleIntegral(growths);
  }

  /** ds/dτ at the nodes. @type {(sc: number) => Float64Array} */
  arcs(sc) {
    return this.rule.nodes.map((tau) => arcDensity(this.theta, sc, tau));
  }

  /** Slopes of the unloaded rod at the nodes and, last, at the contact point. @type {(sc: number) => Float64Array} */
  naturalSlopes(sc) {
    const { rule, theta, mounting } = this;
    return Float64Array.from([...rule.nodes, 1], (tau) => naturalSlope(mounting, arcLength(theta, sc, tau)));
  }

  /** @type {(unknowns: Float64Array) => NodeValues} */
  parts(unknowns) {
    const { nodes: count, rule } = this;
    const fx = unknowns[count];
    const fy = unknowns[count + 1];
    const sc = unknowns[count + 2];
    const kernel = sc === 1 ? this.tipKernel : this.kernel(sc);
    // The natural slopes of a straight rod do not depend on s_c.
    const natural = sc === 1 || this.straight ? this.tipSlopes : this.naturalSlopes(sc);
    const arc = sc === 1 ? this.tipArc : this.arcs(sc);
    const sin = new Float64Array(count);
    const cos = new Float64Array(count);
    const gradient = new Float64Array(count);
    let height = 0;
    let reach = 0;
    for (let i = 0; i < count; i += 1) {
      sin[i] = Math.sin(unknowns[i]);
      cos[i] = Math.cos(unknowns[i]);
      gradient[i] = arc[i] * (fx * sin[i] - fy * cos[i]);
      height += rule.weights[i] * arc[i] * sin[i];
      reach += rule.weights[i] * arc[i] * cos[i];
    }
    const turned = product(kernel, gradient);
    return { kernel, natural, arc, sin, cos, gradient, turned, height, reach };
  }

  /** @type {(unknowns: Float64Array, contact: Contact) => State} */
  state(unknowns, contact) {
    const { natural, gradient, turned, height, reach } = this.parts(unknowns);
    const [fx, fy, sc] = unknowns.subarray(this.nodes);
    let m = 0;
    for (let i = 0; i < this.nodes; i += 1) m -= this.rule.weights[i] * gradient[i];
    const phi1 = contact === "line" ? 0 : natural[this.nodes] - turned[this.nodes];
    return { unknowns, contact, offset: reach + 1 - sc, height, fx, fy, m, phi1, sc };
  }

  /** Derivative of the offset along a change of unknowns. @type {(state: State, change: Float64Array) => number} */
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

  /** Bending moments at the nodes. @type {(unknowns: Float64Array) => Float64Array} */
  moments(unknowns) {
    // The last sum is that up to the contact point, where the moment is zero.
    const sums = product(this.rule.fromStart, this.parts(unknowns).gradient);
    return sums.subarray(0, this.nodes).map((sum) => sum - sums[this.nodes]);
  }

  /** Elastic energy of rod and clamp (M1), in units of E·I0/L. @type {(unknowns: Float64Array) => number} */
  energyOf(unknowns) {
    const { nodes, weights } = this.rule;
    const sc = unknowns[this.nodes + 2];
    const rod = this.moments(unknowns).reduce(
      (sum, m, i) => sum + 0.5 * weights[i] * m * m * this.compliance(sc, nodes[i]),
      0,
    );
    const turn = this.mounting.compliance;
    return turn === 0 ? rod : rod + 0.5 * turn * this.state(unknowns, "point").m ** 2;
  }

  /** Legendre series of a state in τ, from which shapes follow. @type {(state: State) => Series} */
  series({ unknowns, sc }) {
    const { toCoefficients } = this.rule;
    const phi = unknowns.subarray(0, this.nodes);
    const arc = sc === 1 ? this.tipArc : this.arcs(sc);
    return {
      phi: product(toCoefficients, phi),
      along: product(toCoefficients, arc.map((a, k) => a * Math.cos(phi[k]))),
      up: product(toCoefficients, arc.map((a, k) => a * Math.sin(phi[k]))),
    };
  }

  /**
   * The deformed rod at arc lengths, with its clamp at the origin.
   * @type {(state: State, s: Float64Array, series?: Series) => Shape}
   */
  shape(state, s, series = this.series(state)) {
    const [x, y, phi] = [0, 1, 2].map(() => new Float64Array(s.length));
    for (let i = 0; i < s.length; i += 1) {
      const free = Math.min(s[i], state.sc);
      const at = bendingCoordinate(this.theta, state.sc, free);
      const values = legendre(this.nodes, at);
      const integrals = legendreIntegrals(values, at);
      // Beyond the contact point, where the rod is level, it has its natural shape.
      const tail = tailOf(this.mounting, free, s[i]);
      [x[i], y[i], phi[i]] = [tail.along, tail.up, tail.turn];
      for (let k = 0; k < this.nodes; k += 1) {
        x[i] += series.along[k] * integrals[k];
        y[i] += series.up[k] * integrals[k];
        phi[i] += series.phi[k] * values[k];
      }
    }
    return { s, x, y, phi };
  }

  /** Slopes of the free part at arc lengths. @type {(state: State, s: Float64Array) => Float64Array} */
  slopes({ unknowns, sc }, s) {
    const phi = product(this.rule.toCoefficients, unknowns.subarray(0, this.nodes));
    return s.map((free) => {
      const x = 2 * bendingCoordinate(this.theta, sc, free) - 1;
      let [before, value, sum] = [0, 1, 0];
      for (let k = 0; k < phi.length; k += 1) {
        sum += phi[k] * value;
        [before, value] = [value, ((2 * k + 1) * x * value - k * before) / (k + 1)];
      }
      return sum;
    });
  }

  /**
   * Size of the last coefficients of the slope relative to the largest; it is small if the nodes suffice.
   * @type {(state: State) => number}
   */
  decay(state) {
    const coefficients = product(this.rule.toCoefficients, state.unknowns.subarray(0, this.nodes)).map(Math.abs);
    const last = Math.max(...coefficients.subarray(this.nodes - 2));
    return last / Math.max(...coefficients);
  }
}
