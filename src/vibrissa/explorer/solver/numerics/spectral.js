// Polynomials on [0, 1] through Gauss–Legendre nodes: integrals, and values between the nodes.

/** Legendre polynomials P_0 to P_count at one place of [0, 1]. @type {(count: number, at: number) => Float64Array} */
export function legendre(count, at) {
  const x = 2 * at - 1;
  const values = new Float64Array(count + 1);
  values[0] = 1;
  if (count > 0) values[1] = x;
  for (let k = 1; k < count; k += 1) {
    values[k + 1] = ((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1);
  }
  return values;
}

/**
 * Integrals of all but the last of these polynomials, from 0 to the place.
 * @type {(values: Float64Array, at: number) => Float64Array}
 */
export function legendreIntegrals(values, at) {
  const integrals = new Float64Array(values.length - 1);
  integrals[0] = at;
  for (let k = 1; k < integrals.length; k += 1) {
    integrals[k] = (values[k + 1] - values[k - 1]) / (2 * (2 * k + 1));
  }
  return integrals;
}

/** @type {Map<number, Rule>} */
const rules = new Map();

/** Gauss–Legendre rule with a number of nodes, cached. @type {(count: number) => Rule} */
export function gaussRule(count) {
  const rule = rules.get(count) ?? madeRule(count);
  rules.set(count, rule);
  return rule;
}

/** @type {(count: number) => Rule} */
function madeRule(count) {
  const nodes = new Float64Array(count);
  const weights = new Float64Array(count);
  for (let i = 0; i < count; i += 1) {
    [nodes[i], weights[i]] = gaussNode(count, i);
  }
  const toCoefficients = new Float64Array(count * count);
  const fromStart = new Float64Array((count + 1) * count);
  const values = Array.from(nodes, (at) => legendre(count, at));
  for (let k = 0; k < count; k += 1) {
    for (let j = 0; j < count; j += 1) {
      toCoefficients[k * count + j] = (2 * k + 1) * weights[j] * values[j][k];
    }
  }
  for (let i = 0; i < count; i += 1) {
    const integrals = legendreIntegrals(values[i], nodes[i]);
    for (let k = 0; k < count; k += 1) {
      for (let j = 0; j < count; j += 1) {
        fromStart[i * count + j] += integrals[k] * toCoefficients[k * count + j];
      }
    }
  }
  fromStart.set(weights, count * count);
  const kernels = [0, 1, 2].map((power) => kernel(nodes, weights, fromStart, power));
  return { count, nodes, weights, fromStart, toCoefficients, kernels };
}

/** A root of P_count as a node on [0, 1], and its weight. @type {(count: number, i: number) => [number, number]} */
function gaussNode(count, i) {
  let at = 0.5 - 0.5 * Math.cos((Math.PI * (i + 0.75)) / (count + 0.5));
  let slope = 1;
  for (let step = 0; step < 8; step += 1) {
    const values = legendre(count, at);
    // With respect to the place in [0, 1]: (x² − 1)·P' = count·(x·P − P before), x = 2·at − 1.
    const x = 2 * at - 1;
    slope = (2 * count * (x * values[count] - values[count - 1])) / (x * x - 1);
    at -= values[count] / slope;
  }
  return [at, 1 / (at * (1 - at) * slope * slope)];
}

/** @type {(nodes: Float64Array, weights: Float64Array, fromStart: Float64Array, power: number) => Float64Array} */
function kernel(nodes, weights, fromStart, power) {
  const count = nodes.length;
  const product = new Float64Array((count + 1) * count);
  for (let i = 0; i <= count; i += 1) {
    for (let j = 0; j < count; j += 1) {
      const factor = fromStart[i * count + j] * nodes[j] ** power;
      for (let k = 0; k < count; k += 1) {
        product[i * count + k] += factor * (weights[k] - fromStart[j * count + k]);
      }
    }
  }
  return product;
}
