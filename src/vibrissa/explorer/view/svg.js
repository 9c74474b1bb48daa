// Elements of drawings, and numbers as text.

const NAMESPACE = "http://www.w3.org/2000/svg";
/** A smaller number is written with its power of ten. */
const SMALLEST_PLAIN = 1e-3;
/** Rounding errors of a solved state. */
const NOISE = 1e-11;
/** Pixels of the width of a letter, and between two lines of text. */
const LETTER_WIDTH = 6.6;
const LINE_HEIGHT = 13;
/** Pixels between a text and the edge of a drawing. */
const EDGE = 3;
/** Lines by which a text may move to a place where it covers no other. */
const SHIFTS = [0, -1, 1, -2, 2];

/** Add an element to a drawing. @type {(parent: Element, name: string, attributes?: Attributes) => SVGElement} */
export function drawn(parent, name, attributes = {}) {
  const node = document.createElementNS(NAMESPACE, name);
  set(node, attributes);
  parent.append(node);
  return node;
}

/** @type {(node: Element, attributes: Attributes) => void} */
export function set(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
}

/** Write a text if it has changed, as each writing costs a layout. @type {(node: Element, text: string) => void} */
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Elements of a drawing by name: each is added when it is first drawn, and updated later. */
export class Parts {
  /** @param {Element} parent */
  constructor(parent) {
    this.parent = parent;
    /** @type {Map<string, SVGElement>} */
    this.known = new Map();
    /** @type {Map<string, string>} */
    this.drawn = new Map();
    /** Texts of this frame with their places. @type {Map<string, { x: number, y: number, width: number }>} */
    this.taken = new Map();
    this.width = Infinity;
  }

  /** The class is the name without its number. @type {(name: string, kind: string) => SVGElement} */
  part(name, kind) {
    const known = this.known.get(name);
    if (known) return known;
    const made = drawn(this.parent, kind, { class: name.replace(/\d+$/, "") });
    this.known.set(name, made);
    return made;
  }

  /** Draw a path, if it has changed. @type {(name: string, d: string) => void} */
  path(name, d) {
    if (this.isNew(name, d)) set(this.part(name, "path"), { d });
  }

  /** @type {(name: string, look: string) => boolean} */
  isNew(name, look) {
    const known = this.drawn.get(name) === look;
    this.drawn.set(name, look);
    return !known;
  }

  /**
   * Write a text within the width of the drawing, and where it covers no other text of this frame: at most two lines
   * from the place that is given.
   * @type {(name: string, x: number, y: number, text: string, anchor?: string) => void}
   */
  text(name, at, given, text, anchor = "start") {
    const wide = LETTER_WIDTH * text.length;
    const before = { start: 0, middle: 0.5, end: 1 }[/** @type {"start" | "middle" | "end"} */ (anchor)] * wide;
    const x = Math.max(Math.min(at, this.width - EDGE - wide + before), EDGE + before);
    const y = this.freeHeight(name, x - before, given, text);
    if (!this.isNew(name, [x, y, text, anchor].join())) return;
    const node = this.part(name, "text");
    write(node, text);
    if (text) set(node, { x, y, "text-anchor": anchor });
  }

  /** @type {(name: string, left: number, y: number, text: string) => number} */
  freeHeight(name, left, y, text) {
    this.taken.delete(name);
    if (!text) return y;
    const width = LETTER_WIDTH * text.length;
    /** @param {number} at */
    const isFree = (at) => [...this.taken.values()].every((one) => {
      return Math.abs(one.y - at) >= LINE_HEIGHT || one.x + one.width <= left || left + width <= one.x;
    });
    const place = SHIFTS.map((lines) => y + LINE_HEIGHT * lines).find(isFree) ?? y;
    this.taken.set(name, { x: left, y: place, width });
    return place;
  }
}

/**
 * Path through points, with a gap at each NaN.
 * @type {(x: ArrayLike<number>, y: ArrayLike<number>) => string}
 */
export function pathThrough(x, y) {
  const parts = [];
  let pen = "M";
  for (let i = 0; i < x.length; i += 1) {
    const seen = Number.isFinite(x[i]) && Number.isFinite(y[i]);
    // A tenth of a pixel is enough.
    if (seen) parts.push(pen, Math.round(10 * x[i]) / 10, " ", Math.round(10 * y[i]) / 10);
    pen = seen ? "L" : "M";
  }
  return parts.length ? parts.join("") : "M0 0";
}

/**
 * A number with `digits` digits after the point and a typographic minus sign; a dash for NaN.
 * @type {(value: number, digits: number) => string}
 */
export function spelled(value, digits) {
  if (value === Infinity) return "∞";
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** A number to four significant digits, a small one with its power of ten. @type {(value: number) => string} */
export function significant(value) {
  if (value === 0 || !Number.isFinite(value)) return spelled(value, 0);
  if (Math.abs(value) < SMALLEST_PLAIN) return value.toExponential(3).replace(/-/g, "−");
  const size = Math.floor(Math.log10(Math.abs(value)));
  return spelled(value, Math.max(0, 3 - size));
}

/** A nondimensional value; 0 if it is a rounding error. @type {(value: number) => number} */
export function withoutNoise(value) {
  return Math.abs(value) < NOISE ? 0 : value;
}

/**
 * Round values that divide a span into at most `most` parts.
 * @type {(low: number, high: number, most: number) => { values: number[], digits: number }}
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
