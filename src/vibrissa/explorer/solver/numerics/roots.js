// A root of a function between two places at which it has different signs.

const MOST_SECANTS = 400;

/**
 * Find a root by the Illinois method: secants, and at times the middle of the bracket. Returns NaN if a
 * value is NaN; `tolerance` is the accuracy of the place.
 * @type {(value: (at: number) => number, low: number, high: number, valueLow: number, valueHigh: number,
 *   tolerance: number) => number}
 */
export function bracketedRoot(value, low, high, valueLow, valueHigh, tolerance) {
  let [a, fa, b, fb] = [low, valueLow, high, valueHigh];
  if (fa === 0) return a;
  if (fb === 0) return b;
  let side = 0;
  for (let step = 0; step < MOST_SECANTS && Math.abs(b - a) > tolerance; step += 1) {
    let at = (a * fb - b * fa) / (fb - fa);
    if (!(at > Math.min(a, b) && at < Math.max(a, b)) || step % 8 === 7) at = 0.5 * (a + b);
    const found = value(at);
    if (found === 0 || Number.isNaN(found)) return Number.isNaN(found) ? NaN : at;
    if (found > 0 === fb > 0) {
      [b, fb] = [at, found];
      // Halve the value at an end that stays twice.
      if (side === 1) fa *= 0.5;
      side = 1;
    } else {
      [a, fa] = [at, found];
      if (side === -1) fb *= 0.5;
      side = -1;
    }
  }
  return Math.abs(fa) < Math.abs(fb) ? a : b;
}
