// Elements of drawings, and numbers as text.

const NAMESPACE = "http://www.w3.org/2000/svg";
/** What is smaller is written with its power of ten. */
const SMALLEST_PLAIN = 1e-3;
/** Rounding errors of a solved state. */
const NOISE = 1e-11;

/**
 * Add an element to a drawing.
 *
 * @param {Element} parent
 * @param {string} name
 * @param {Record<string, string | number>} [attributes]
 * @returns {SVGElement}
 */
export function drawn(parent, name, attributes = {}) {
  const node = document.createElementNS(NAMESPACE, name);
  set(node, attributes);
  parent.append(node);
  return node;
}

/**
 * @param {Element} node
 * @param {Record<string, string | number>} attributes
 */
export function set(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
}

/**
 * Put a text into an element where it is another one: only then the page is laid out anew.
 *
 * @param {Element} node
 * @param {string} text
 */
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/**
 * Path through points; a point that is not a number lifts the pen.
 *
 * @param {ArrayLike<number>} x
 * @param {ArrayLike<number>} y
 * @returns {string}
 */
export function pathThrough(x, y) {
  const parts = [];
  let pen = "M";
  let [lastX, lastY] = [NaN, NaN];
  for (let i = 0; i < x.length; i += 1) {
    // A tenth of a pixel is enough; points that then are the same are one.
    const [px, py] = [Math.round(10 * x[i]) / 10, Math.round(10 * y[i]) / 10];
    if (!Number.isFinite(px) || !Number.isFinite(py)) {
      pen = "M";
      lastX = NaN;
    } else if (px !== lastX || py !== lastY) {
      parts.push(pen, px, " ", py);
      pen = "L";
      [lastX, lastY] = [px, py];
    }
  }
  return parts.length ? parts.join("") : "M0 0";
}

/**
 * A number as text, with a real minus sign; a dash where there is none.
 *
 * @param {number} value
 * @param {number} digits After the point.
 * @returns {string}
 */
export function spelled(value, digits) {
  if (value === Infinity) return "∞";
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/**
 * A number to four significant digits, a small one with its power of ten.
 *
 * @param {number} value
 * @returns {string}
 */
export function significant(value) {
  if (value === 0 || !Number.isFinite(value)) return spelled(value, 0);
  if (Math.abs(value) < SMALLEST_PLAIN) return value.toExponential(3).replace(/-/g, "−");
  const size = Math.floor(Math.log10(Math.abs(value)));
  return spelled(value, Math.max(0, 3 - size));
}

/**
 * A value of the model, 0 where it differs from it by rounding errors alone.
 *
 * @param {number} value In units of L and E·I0.
 * @returns {number}
 */
export function withoutNoise(value) {
  return Math.abs(value) < NOISE ? 0 : value;
}

/**
 * Round values that divide a span into few parts.
 *
 * @param {number} low
 * @param {number} high
 * @param {number} most
 * @returns {{ values: number[], digits: number }}
 */
export function ticks(low, high, most) {
  const raw = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= raw * (1 - 1e-9)) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  const count = Math.floor(high / step + 1e-9) - first + 1;
  const values = Array.from({ length: Math.max(0, count) }, (_, k) => (first + k) * step);
  return { values, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}
