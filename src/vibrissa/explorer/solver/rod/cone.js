// The free part of the rod, a cone, in its bending coordinate τ: (1) and (5) of docs/model.md.

/**
 * Inverse diameter g + b·τ of the free part, in units of that of the tip: (5) of docs/model.md.
 *
 * @param {number} theta
 * @param {number} sc
 * @returns {{ g: number, b: number }}
 */
function inverseDiameter(theta, sc) {
  const b = (theta - 1) * sc;
  return { g: theta - b, b };
}

/**
 * @param {number} theta
 * @param {number} sc
 * @param {number} tau
 * @returns {number} ds/dτ.
 */
export function arcDensity(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return (theta * sc * g) / (g + b * tau) ** 2;
}

/**
 * @param {number} theta
 * @param {number} sc
 * @param {number} tau
 * @returns {number} Logarithmic derivative of ds/dτ with respect to s_c.
 */
export function arcGrowth(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return 1 / sc - (theta - 1) / g + (2 * (theta - 1) * (1 - tau)) / (g + b * tau);
}

/**
 * @param {number} theta
 * @param {number} sc
 * @param {number} tau
 * @returns {number} B⁻¹·ds/dτ.
 */
export function compliance(theta, sc, tau) {
  const [c0, c1, c2] = compliances(theta, sc);
  return c0 + tau * (c1 + tau * c2);
}

/**
 * @param {number} theta
 * @param {number} sc
 * @returns {number[]} Factors of 1, τ and τ² in B⁻¹·ds/dτ.
 */
export function compliances(theta, sc) {
  const { g, b } = inverseDiameter(theta, sc);
  return [(theta * sc) / g, (2 * theta * sc * b) / g ** 2, (theta * sc * b ** 2) / g ** 3];
}

/**
 * @param {number} theta
 * @param {number} sc
 * @returns {number[]} Derivatives of `compliances` with respect to s_c.
 */
export function complianceGrowths(theta, sc) {
  const { g, b } = inverseDiameter(theta, sc);
  const t = theta - 1;
  return [
    theta * (1 / g + (sc * t) / g ** 2),
    2 * theta * (b / g ** 2 + (sc * t) / g ** 2 + (2 * sc * b * t) / g ** 3),
    theta * (b ** 2 / g ** 3 + (2 * sc * b * t) / g ** 3 + (3 * sc * b ** 2 * t) / g ** 4),
  ];
}

/**
 * @param {number} theta
 * @param {number} sc
 * @param {number} s Arc length on the free part.
 * @returns {number} τ.
 */
export function bendingCoordinate(theta, sc, s) {
  // Inverse of s = θ·s_c·τ/h: s·(g + b·τ) = θ·s_c·τ.
  const { g, b } = inverseDiameter(theta, sc);
  return (s * g) / (theta * sc - b * s);
}

/**
 * @param {number} theta
 * @param {number} sc
 * @param {number} tau
 * @returns {number} Arc length s(τ).
 */
export function arcLength(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return (theta * sc * tau) / (g + b * tau);
}

/**
 * @param {number} theta
 * @param {number} sc
 * @param {number} tau
 * @returns {number} Derivative of `arcLength` with respect to s_c at a fixed τ.
 */
export function arcLengthGrowth(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return (theta ** 2 * tau) / (g + b * tau) ** 2;
}
