// Mounting of a rod: its clamp, its natural curvature, the path of its stage. See docs/mounting.md.

/** @type {Mounting} */
export const IDEAL = { angle: 0, compliance: 0, curvature: [0], stage: 0 };
/** @type {Making} */
export const SOLID = { powers: [], bore: 0 };
/** Slope of the rod at an upright, rigid clamp. */
export const CLAMP_SLOPE = Math.PI / 2;
/** Number of intervals over which the natural shape of a tail is integrated. */
const TAIL_PARTS = 16;

/** @type {(mounting: Mounting) => boolean} */
export function isStraight({ curvature }) {
  return curvature.every((value) => value === 0);
}

/** Whether the rod is solid and of one material. @type {(mounting: Mounting) => boolean} */
export function isSolid({ making = SOLID }) {
  return making.bore === 0 && making.powers.every((value) => value === 0);
}

/** Whether the clamp is the paper's and the rod straight. @type {(mounting: Mounting) => boolean} */
export function isIdealRod(mounting) {
  return mounting.angle === 0 && mounting.compliance === 0 && isStraight(mounting);
}

/** κ0 at an arc length. @type {(mounting: Mounting, s: number) => number} */
export function naturalCurvature({ curvature }, s) {
  return curvature.reduceRight((sum, value) => sum * s + value, 0);
}

/** Slope of the unloaded rod, π/2 + β + ∫κ0. @type {(mounting: Mounting, s: number) => number} */
export function naturalSlope({ angle, curvature }, s) {
  const turn = curvature.reduceRight((sum, value, k) => sum * s + value / (k + 1), 0);
  return CLAMP_SLOPE + angle + s * turn;
}

/**
 * Mounting with a share of the deviations of clamp and rod from the ideal; the stage stays the same.
 * @type {(mounting: Mounting, share: number) => Mounting}
 */
export function scaledMounting({ angle, compliance, curvature, stage, making = SOLID }, share) {
  return {
    angle: share * angle,
    compliance: share * compliance,
    curvature: curvature.map((value) => share * value),
    stage,
    making: { powers: making.powers.map((value) => share * value), bore: share * making.bore },
  };
}

/**
 * Natural shape of a tail between arc lengths, in axes along the rod at `from` and normal to it.
 * @type {(mounting: Mounting, from: number, to: number) => { along: number, up: number, turn: number }}
 */
export function tailOf(mounting, from, to) {
  const [begin, length] = [naturalSlope(mounting, from), to - from];
  if (length <= 0 || isStraight(mounting)) return { along: length, up: 0, turn: 0 };
  let [along, up] = [0, 0];
  for (let k = 0; k <= 2 * TAIL_PARTS; k += 1) {
    // Simpson's rule.
    const weight = (k === 0 || k === 2 * TAIL_PARTS ? 1 : k % 2 ? 4 : 2) / (6 * TAIL_PARTS);
    const turn = naturalSlope(mounting, from + (k / (2 * TAIL_PARTS)) * length) - begin;
    along += weight * length * Math.cos(turn);
    up += weight * length * Math.sin(turn);
  }
  return { along, up, turn: naturalSlope(mounting, to) - begin };
}
