// A plot with axes: lines, marks and labels by name, each moved and not drawn anew.

import { drawn, pathThrough, set, spelled, ticks } from "./svg.js";

/**
 * @typedef {object} Frame
 * @property {number} left
 * @property {number} right
 * @property {number} low
 * @property {number} high
 */

const MARGIN = { left: 46, right: 12, top: 10, bottom: 24 };
let plots = 0;

export class Plot {
  /**
   * @param {SVGSVGElement} svg
   * @param {{ across: boolean }} options Whether values along x are labelled.
   */
  constructor(svg, { across }) {
    this.svg = svg;
    this.margin = { ...MARGIN, bottom: across ? MARGIN.bottom : 6 };
    this.across = across;
    this.grid = drawn(svg, "g", { class: "grid" });
    this.labels = drawn(svg, "g", { class: "ticks" });
    plots += 1;
    const clip = `x-clip-${plots}`;
    this.clip = drawn(drawn(svg, "clipPath", { id: clip }), "rect");
    // Marks and texts may pass the edges, lines may not.
    this.lines = drawn(svg, "g", { "clip-path": `url(#${clip})` });
    this.content = drawn(svg, "g");
    /** @type {Map<string, SVGElement>} */
    this.parts = new Map();
    /** @type {Frame} */
    this.frame = { left: 0, right: 1, low: 0, high: 1 };
    [this.width, this.height] = [300, 150];
    this.key = "";
  }

  /** Take the size that the page gives the drawing; ask before drawing, as it costs a layout. */
  resize() {
    const { clientWidth, clientHeight } = this.svg;
    this.width = clientWidth || this.width;
    this.height = clientHeight || this.height;
    set(this.svg, { viewBox: `0 0 ${this.width} ${this.height}` });
    const { left, right, top, bottom } = this.margin;
    const width = Math.max(0, this.width - left - right);
    set(this.clip, { x: left, y: top, width, height: Math.max(0, this.height - top - bottom) });
    this.key = "";
  }

  /** @param {number} value */
  x(value) {
    const { left, right } = this.frame;
    const span = this.width - this.margin.left - this.margin.right;
    return this.margin.left + (span * (value - left)) / (right - left);
  }

  /** @param {number} value */
  y(value) {
    const { low, high } = this.frame;
    const span = this.height - this.margin.top - this.margin.bottom;
    return this.margin.top + (span * (high - value)) / (high - low);
  }

  /**
   * Value at a place across the drawing.
   *
   * @param {number} px
   * @param {number} py
   * @returns {{ x: number, y: number }}
   */
  valueAt(px, py) {
    const { left, right, low, high } = this.frame;
    const wide = this.width - this.margin.left - this.margin.right;
    const tall = this.height - this.margin.top - this.margin.bottom;
    return {
      x: left + ((px - this.margin.left) / wide) * (right - left),
      y: high - ((py - this.margin.top) / tall) * (high - low),
    };
  }

  /**
   * Set the values at the edges, and draw the axes where they have changed.
   *
   * @param {Frame} frame
   * @returns {boolean} Whether they have.
   */
  setFrame(frame) {
    const key = [frame.left, frame.right, frame.low, frame.high, this.width, this.height].join();
    if (key === this.key) return false;
    [this.key, this.frame] = [key, frame];
    this.grid.replaceChildren();
    this.labels.replaceChildren();
    const { margin, width, height } = this;
    const bottom = height - margin.bottom;
    const down = ticks(frame.low, frame.high, Math.max(2, Math.floor(height / 38)));
    for (const value of down.values) {
      const y = this.y(value);
      drawn(this.grid, "path", { d: `M${margin.left} ${y}H${width - margin.right}` });
      const text = drawn(this.labels, "text", { x: margin.left - 6, y: y + 3.5, class: "end" });
      text.textContent = spelled(value, down.digits);
    }
    const along = ticks(frame.left, frame.right, Math.max(2, Math.floor(width / 58)));
    for (const value of along.values) {
      const x = this.x(value);
      drawn(this.grid, "path", { d: `M${x} ${margin.top}V${bottom}` });
      if (!this.across) continue;
      const text = drawn(this.labels, "text", { x, y: bottom + 15, class: "middle" });
      text.textContent = spelled(value, along.digits);
    }
    return true;
  }

  /**
   * @param {string} name
   * @param {string} kind
   * @returns {SVGElement}
   */
  part(name, kind) {
    const known = this.parts.get(name);
    if (known) return known;
    const made = drawn(kind === "path" ? this.lines : this.content, kind, { class: name.replace(/\d+$/, "") });
    this.parts.set(name, made);
    return made;
  }

  /**
   * Draw a line through values.
   *
   * @param {string} name Also its class.
   * @param {number[]} x
   * @param {number[]} y
   */
  line(name, x, y) {
    const { low, high } = this.frame;
    const span = high - low;
    // What lies far outside would make a drawing of any size.
    const seen = y.map((value) => (value > high + span || value < low - span ? NaN : value));
    const d = pathThrough(x.map((value) => this.x(value)), seen.map((value) => this.y(value)));
    set(this.part(name, "path"), { d });
  }

  /**
   * Fill between a line and a constant.
   *
   * @param {string} name
   * @param {number[]} x
   * @param {number[]} y
   * @param {number} base
   */
  area(name, x, y, base) {
    const { low, high } = this.frame;
    const known = x.map((_, i) => i).filter((i) => Number.isFinite(y[i]) || y[i] === Infinity);
    if (!known.length) return set(this.part(name, "path"), { d: "M0 0" });
    const inside = known.map((i) => Math.min(high, Math.max(low, y[i])));
    const xs = known.map((i) => this.x(x[i]));
    const ends = `L${xs[xs.length - 1]} ${this.y(base)}L${xs[0]} ${this.y(base)}Z`;
    set(this.part(name, "path"), {
      d: pathThrough(xs, inside.map((value) => this.y(value))) + ends,
    });
  }

  /**
   * Draw a point; none where it is not known or outside.
   *
   * @param {string} name
   * @param {number} x
   * @param {number} y
   * @param {number} radius
   */
  mark(name, x, y, radius) {
    const { left, right, low, high } = this.frame;
    const seen = x >= left && x <= right && y >= low && y <= high;
    const node = this.part(name, "circle");
    set(node, { r: seen ? radius : 0 });
    if (seen) set(node, { cx: this.x(x), cy: this.y(y) });
  }

  /**
   * Write beside a point; nothing where it is not known or outside.
   *
   * @param {string} name
   * @param {number} x
   * @param {number} y
   * @param {string} text
   * @param {{ dx?: number, dy?: number, end?: boolean }} [options]
   */
  label(name, x, y, text, { dx = 0, dy = 0, end = false } = {}) {
    const node = this.part(name, "text");
    const { left, right, low, high } = this.frame;
    const seen = x >= left && x <= right && y >= low && y <= high;
    if (node.textContent !== (seen ? text : "")) node.textContent = seen ? text : "";
    if (!seen) return;
    set(node, {
      x: this.x(x) + dx,
      y: this.y(y) + dy,
      ...(end ? { "text-anchor": "end" } : {}),
    });
  }
}
