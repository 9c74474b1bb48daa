// How well the readings of the model fit a recording.

/** @type {[keyof Omit<Recording, "name">, string][]} */
const CHANNELS = [["fx", "Fx"], ["fy", "Fy"], ["m", "M"]];

/** The readings of the last motion in one direction, with rising clamp positions. @type {(trace: Reading[]) => Reading[]} */
function lastMotion(trace) {
  let first = trace.length - 1;
  while (first > 0 && trace[first - 1].clamp <= trace[first].clamp) first -= 1;
  return trace.slice(Math.max(0, first));
}

/** A reading at a position of the clamp, interpolated; NaN outside. @type {(rows: Reading[], key: "fx" | "fy" | "m", clamp: number) => number} */
function interpolated(rows, key, clamp) {
  let [low, high] = [0, rows.length - 1];
  if (!(clamp >= rows[low].clamp && clamp <= rows[high].clamp)) return NaN;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rows[middle].clamp <= clamp) low = middle;
    else high = middle;
  }
  const [a, b] = [rows[low], rows[high]];
  const part = b.clamp > a.clamp ? (clamp - a.clamp) / (b.clamp - a.clamp) : 0;
  return a[key] + part * (b[key] - a[key]);
}

/** Root mean square difference of each channel, as a part of its range. @type {(trace: Reading[], recording: Recording) => string} */
export function misfitOf(trace, recording) {
  const rows = lastMotion(trace);
  const samples = recording.clamp.filter(Number.isFinite).length;
  let compared = 0;
  const parts = CHANNELS.flatMap(([key, symbol]) => {
    let [sum, count, low, high] = [0, 0, Infinity, -Infinity];
    recording[key].forEach((value, i) => {
      const away = value - interpolated(rows, /** @type {"fx" | "fy" | "m"} */ (key), recording.clamp[i]);
      if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
      if (Number.isFinite(away)) [sum, count] = [sum + away * away, count + 1];
    });
    compared = Math.max(compared, count);
    return count ? [`${symbol} ${(100 * Math.sqrt(sum / count) / (high - low || 1)).toPrecision(2)} %`] : [];
  });
  if (!parts.length) return "Move the clamp over its range to compare.";
  const share = Math.round((100 * compared) / samples);
  return `Difference from the model (root mean square, of the range): ${parts.join(", ")}; ${share} % of the samples compared.`;
}
