// A plot with axes: named lines, marks and labels, which are updated in place; values at the pointer.

import { drawn, Parts, pathThrough, set, significant, spelled, ticks, withoutNoise } from "./svg.js";

const MARGIN = { left: 46, right: 12, top: 10, bottom: 24 };
/** Pixels from the pointer within which a line shows its values. */
const POINTED = 40;

export class Plot {
  /**
   * @param {SVGSVGElement} svg
   * @param {boolean} across Whether values along x are labelled.
   */
  constructor(svg, across) {
    this.svg = svg;
    this.margin = { ...MARGIN, bottom: across ? MARGIN.bottom : 6 };
    this.across = across;
    this.grid = drawn(svg, "g", { class: "grid" });
    this.ticks = drawn(svg, "g", { class: "ticks" });
    const clip = `x-clip-${svg.dataset.x}`;
    this.clip = drawn(drawn(svg, "clipPath", { id: clip }), "rect");
    // Marks and texts may pass the edges, lines may not.
    this.lines = new Parts(drawn(svg, "g", { "clip-path": `url(#${clip})` }));
    this.content = new Parts(drawn(svg, "g"));
    /** @type {Frame} */
    this.frame = { left: 0, right: 1, low: 0, high: 1 };
    /** Names and units of x and y, for the values at the pointer. */
    this.axes = { x: ["", ""], y: ["", ""] };
    /** @type {{ x: number[], y: number[] }} The line that shows its values. */
    this.curve = { x: [], y: [] };
    /** @type {Point | null} */
    this.pointer = null;
    [this.width, this.height] = [300, 150];
    this.key = "";
    svg.addEventListener("pointermove", (event) => this.hover(this.placeOf(event)));
    svg.addEventListener("pointerleave", () => this.hover(null));
  }

  /** Take over the size of the drawing on the page; call it before drawing, as it costs a layout. */
  resize() {
    const { clientWidth, clientHeight } = this.svg;
    this.width = clientWidth || this.width;
    this.height = clientHeight || this.height;
    set(this.svg, { viewBox: `0 0 ${this.width} ${this.height}` });
    this.content.width = this.width;
    const { left, right, top, bottom } = this.margin;
    const width = Math.max(0, this.width - left - right);
    set(this.clip, { x: left, y: top, width, height: Math.max(0, this.height - top - bottom) });
    this.key = "";
  }

  /** @type {(value: number) => number} */
  x(value) {
    const { left, right } = this.frame;
    const span = this.width - this.margin.left - this.margin.right;
    return this.margin.left + (span * (value - left)) / (right - left);
  }

  /** @type {(value: number) => number} */
  y(value) {
    const { low, high } = this.frame;
    const span = this.height - this.margin.top - this.margin.bottom;
    return this.margin.top + (span * (high - value)) / (high - low);
  }

  /** Pixels from the drawing's corner. @type {(event: PointerEvent) => Point} */
  placeOf({ clientX, clientY }) {
    const box = this.svg.getBoundingClientRect();
    return { x: clientX - box.left, y: clientY - box.top };
  }

  /** Values at a place in the drawing. @type {(place: Point) => Point} */
  valueAt({ x, y }) {
    const { left, right, low, high } = this.frame;
    const wide = this.width - this.margin.left - this.margin.right;
    const tall = this.height - this.margin.top - this.margin.bottom;
    return {
      x: left + ((x - this.margin.left) / wide) * (right - left),
      y: high - ((y - this.margin.top) / tall) * (high - low),
    };
  }

  /** Set the values at the edges; if they have changed, draw the axes. @type {(frame: Frame) => void} */
  setFrame(frame) {
    this.content.taken.clear();
    const key = [frame.left, frame.right, frame.low, frame.high, this.width, this.height].join();
    if (key === this.key) return;
    [this.key, this.frame] = [key, frame];
    this.grid.replaceChildren();
    this.ticks.replaceChildren();
    const { margin, width, height } = this;
    const bottom = height - margin.bottom;
    const down = ticks(frame.low, frame.high, Math.max(2, Math.min(6, height / 38)));
    for (const value of down.values) {
      const y = this.y(value);
      drawn(this.grid, "path", { d: `M${margin.left} ${y}H${width - margin.right}` });
      const text = drawn(this.ticks, "text", { x: margin.left - 6, y: y + 3.5, "text-anchor": "end" });
      text.textContent = spelled(value, down.digits);
    }
    const along = ticks(frame.left, frame.right, Math.max(2, Math.min(6, width / 58)));
    for (const value of along.values) {
      const x = this.x(value);
      drawn(this.grid, "path", { d: `M${x} ${margin.top}V${bottom}` });
      if (!this.across) continue;
      const text = drawn(this.ticks, "text", { x, y: bottom + 15, "text-anchor": "middle" });
      text.textContent = spelled(value, along.digits);
    }
  }

  /** Draw a line; its name is its class, too. @type {(name: string, x: number[], y: number[]) => void} */
  line(name, x, y) {
    const { low, high } = this.frame;
    const span = high - low;
    // Points far outside would make the drawing arbitrarily large.
    const seen = y.map((value) => (value > high + span || value < low - span ? NaN : value));
    const [px, py] = [x.map((value) => this.x(value)), seen.map((value) => this.y(value))];
    this.lines.path(name, pathThrough(px, py));
    if (name !== "curve") return;
    this.curve = { x, y };
    if (this.pointer) this.hover(this.pointer);
  }

  /** Fill between a line and a constant. @type {(name: string, x: number[], y: number[], base: number) => void} */
  area(name, x, y, base) {
    const { low, high } = this.frame;
    const known = x.map((_, i) => i).filter((i) => Number.isFinite(y[i]) || y[i] === Infinity);
    if (!known.length) return this.lines.path(name, "M0 0");
    const inside = known.map((i) => Math.min(high, Math.max(low, y[i])));
    const xs = known.map((i) => this.x(x[i]));
    const ends = `L${xs[xs.length - 1]} ${this.y(base)}L${xs[0]} ${this.y(base)}Z`;
    this.lines.path(name, pathThrough(xs, inside.map((value) => this.y(value))) + ends);
  }

  /** @type {(x: number, y: number) => boolean} */
  isInside(x, y) {
    const { left, right, low, high } = this.frame;
    return x >= left && x <= right && y >= low && y <= high;
  }

  /** Draw a point, unless it is outside. @type {(name: string, x: number, y: number, radius: number) => void} */
  mark(name, x, y, radius) {
    const inside = this.isInside(x, y);
    const [cx, cy] = inside ? [this.x(x), this.y(y)] : [0, 0];
    set(this.content.part(name, "circle"), { cx, cy, r: inside ? radius : 0 });
  }

  /**
   * Write a text beside a point, unless it is outside; the text stays within the width of the drawing.
   * @type {(name: string, x: number, y: number, text: string, shift?: { dx?: number, dy?: number, end?: boolean }) => void}
   */
  label(name, x, y, text, { dx = 0, dy = 0, end = false } = {}) {
    const inside = this.isInside(x, y);
    const [px, py] = inside ? [this.x(x), this.y(y)] : [0, 0];
    const flip = end || px > 0.7 * this.width;
    this.content.text(name, flip ? px - dx : px + dx, py + dy, inside ? text : "", flip ? "end" : "start");
  }

  /** Show the values of the curve next to the pointer. @type {(pointer: Point | null) => void} */
  hover(pointer) {
    this.pointer = pointer;
    let [x, y, least] = [NaN, NaN, POINTED];
    for (let i = 0; pointer && i < this.curve.x.length; i += 1) {
      const away = Math.hypot(this.x(this.curve.x[i]) - pointer.x, this.y(this.curve.y[i]) - pointer.y);
      if (away < least) [x, y, least] = [this.curve.x[i], this.curve.y[i], away];
    }
    this.mark("hovermark", x, y, 3);
    const texts = Object.entries(this.axes).map(([key, [name, unit]]) => {
      return `${name} = ${significant(withoutNoise(key === "x" ? x : y))} ${unit}`.trim();
    });
    const above = this.y(y) > 30;
    this.label("hovertext", x, y, texts.join(", "), { dx: 8, dy: above ? -10 : 20 });
  }
}
