// The free part of the rod, a cone, in its bending coordinate τ: (1) and (5) of docs/model.md.

/**
 * Coefficients of g + b·τ, which is proportional to the inverse diameter of the free part: (5) of docs/model.md.
 * @type {(theta: number, sc: number) => { g: number, b: number }}
 */
function inverseDiameter(theta, sc) {
  const b = (theta - 1) * sc;
  return { g: theta - b, b };
}

/** ds/dτ. @type {(theta: number, sc: number, tau: number) => number} */
export function arcDensity(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return (theta * sc * g) / (g + b * tau) ** 2;
}

/** Logarithmic derivative of ds/dτ with respect to s_c. @type {(theta: number, sc: number, tau: number) => number} */
export function arcGrowth(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return 1 / sc - (theta - 1) / g + (2 * (theta - 1) * (1 - tau)) / (g + b * tau);
}

/** B⁻¹·ds/dτ. @type {(theta: number, sc: number, tau: number) => number} */
export function compliance(theta, sc, tau) {
  const [c0, c1, c2] = compliances(theta, sc);
  return c0 + tau * (c1 + tau * c2);
}

/** Factors of 1, τ and τ² in B⁻¹·ds/dτ. @type {(theta: number, sc: number) => number[]} */
export function compliances(theta, sc) {
  const { g, b } = inverseDiameter(theta, sc);
  return [(theta * sc) / g, (2 * theta * sc * b) / g ** 2, (theta * sc * b ** 2) / g ** 3];
}

/** Derivatives of `compliances` with respect to s_c. @type {(theta: number, sc: number) => number[]} */
export function complianceGrowths(theta, sc) {
  const { g, b } = inverseDiameter(theta, sc);
  const t = theta - 1;
  return [
    theta * (1 / g + (sc * t) / g ** 2),
    2 * theta * (b / g ** 2 + (sc * t) / g ** 2 + (2 * sc * b * t) / g ** 3),
    theta * (b ** 2 / g ** 3 + (2 * sc * b * t) / g ** 3 + (3 * sc * b ** 2 * t) / g ** 4),
  ];
}

/** τ at an arc length of the free part. @type {(theta: number, sc: number, s: number) => number} */
export function bendingCoordinate(theta, sc, s) {
  // Inverse of s = θ·s_c·τ/h: s·(g + b·τ) = θ·s_c·τ.
  const { g, b } = inverseDiameter(theta, sc);
  return (s * g) / (theta * sc - b * s);
}

/**
 * Factor e(s) of the bending stiffness, from the modulus along the rod and a bore: (1a) of docs/model.md.
 * @type {(theta: number, making: Making, s: number) => number}
 */
export function stiffnessFactor(theta, { powers, bore }, s) {
  const rise = powers.reduceRight((sum, power) => (sum + power) * s, 0);
  const hollow = (bore / diameter(theta, s)) ** 4;
  return ((1 + rise) * (1 - hollow)) / (1 - bore ** 4);
}

/**
 * Logarithmic derivative of `stiffnessFactor` with respect to s.
 * @type {(theta: number, making: Making, s: number) => number}
 */
export function stiffnessGrowth(theta, { powers, bore }, s) {
  const rise = powers.reduceRight((sum, power) => (sum + power) * s, 0);
  const slope = powers.reduceRight((sum, power, k) => sum * s + (k + 1) * power, 0);
  const d = diameter(theta, s);
  const hollow = (bore / d) ** 4;
  return slope / (1 + rise) - ((4 * hollow) / (1 - hollow)) * ((1 - 1 / theta) / d);
}

/** Diameter (d0). @type {(theta: number, s: number) => number} */
function diameter(theta, s) {
  return 1 - (1 - 1 / theta) * s;
}

/** Arc length s(τ). @type {(theta: number, sc: number, tau: number) => number} */
export function arcLength(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return (theta * sc * tau) / (g + b * tau);
}

/** Derivative of `arcLength` by s_c at a fixed τ. @type {(theta: number, sc: number, tau: number) => number} */
export function arcLengthGrowth(theta, sc, tau) {
  const { g, b } = inverseDiameter(theta, sc);
  return (theta ** 2 * tau) / (g + b * tau) ** 2;
}
