// The rod between its clamp and the surface, with the force in its friction cone.

import { drawn, pathThrough, set, spelled, ticks } from "./svg.js";

/**
 * What is to be seen: lengths in units of L, the clamp at the height 0.
 *
 * @typedef {object} Scene
 * @property {number} theta
 * @property {number} eta
 * @property {number} mu0
 * @property {number} clamp Its place along the surface.
 * @property {number} rise Height of the clamp over that at the start.
 * @property {number} lean Inclination of the clamp (degrees).
 * @property {number} contact Place at which the rod touches the surface.
 * @property {number} side
 * @property {Float64Array} s
 * @property {Float64Array} x Relative to the clamp, with the tip ahead.
 * @property {Float64Array} y
 * @property {number} fx
 * @property {number} fy
 * @property {number} length What a length is multiplied with, for the ruler.
 * @property {number} unit Force that is drawn as long as a quarter of L.
 * @property {boolean} slides Whether the tip has just slipped.
 * @property {{ x: Float64Array, y: Float64Array, clamp: number, rise: number, side: number } | null} ghost
 */

/** Half of the base's diameter, and the clamp's size, in parts of L; exaggerated. */
const HALF_BASE = 0.016;
const HALF_CLAMP = 0.045;
/** Room above the surface and below the clamp (L). */
const ABOVE = 0.12;
const BELOW = 0.16;
/** Where in the window the clamp is kept, from its left edge. */
const KEPT = { from: 0.2, to: 0.55 };
const ARROW = 0.25;
const CONE = 0.3;

export class Stage {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.svg = svg;
    this.hatch = drawn(svg, "path", { class: "hatch" });
    this.surface = drawn(svg, "path", { class: "surface" });
    this.cone = drawn(svg, "path", { class: "cone" });
    this.ruler = drawn(svg, "g", { class: "ruler" });
    this.ghost = drawn(svg, "path", { class: "ghost" });
    this.rod = drawn(svg, "path", { class: "rod" });
    this.arrow = drawn(svg, "path", { class: "arrow" });
    this.contact = drawn(svg, "circle", { class: "contact", r: 6 });
    this.clamp = drawn(svg, "g", {
      class: "clamp",
      tabindex: 0,
      role: "slider",
      "aria-label": "Clamp",
      "aria-valuemin": -5,
      "aria-valuemax": 50,
    });
    this.body = drawn(this.clamp, "path");
    this.grip = drawn(this.clamp, "path", { class: "grip" });
    this.width = 600;
    this.height = 400;
    this.scale = 300;
    this.left = -0.5;
    this.above = ABOVE;
    this.key = "";
  }

  /** Take the size that the page gives the drawing. */
  resize() {
    this.width = this.svg.clientWidth || this.width;
    this.height = this.svg.clientHeight || this.height;
    set(this.svg, { viewBox: `0 0 ${this.width} ${this.height}` });
    this.key = "";
  }

  /** @param {number} x */
  x(x) {
    return (x - this.left) * this.scale;
  }

  /** @param {Scene} scene */
  show(scene) {
    this.look(scene);
    const top = this.above * this.scale;
    /** @param {number} y */
    const up = (y) => top + (scene.eta - y) * this.scale;
    set(this.rod, { d: this.outline(scene, (y) => up(y + scene.rise)) });
    const { ghost } = scene;
    set(this.ghost, { d: ghost ? this.line(ghost, (y) => up(y + ghost.rise)) : "M0 0" });
    const half = HALF_CLAMP * this.scale;
    const [x, y] = [this.x(scene.clamp), up(scene.rise)];
    const turn = `rotate(${-scene.lean} ${x} ${y})`;
    set(this.body, { transform: turn });
    set(this.grip, { transform: turn });
    set(this.body, { d: `M${x - half} ${y}h${2 * half}v${1.2 * half}h${-2 * half}z` });
    const step = half / 3;
    const lines = [-step, 0, step].map((d) => `M${x + d} ${y + 0.35 * half}v${0.5 * half}`);
    set(this.grip, { d: lines.join("") });
    const at = this.x(scene.contact);
    set(this.contact, { cx: at, cy: top });
    this.contact.classList.toggle("slides", scene.slides);
    this.drawForce(scene, at, top);
  }

  /**
   * Move the window after the clamp, and draw what rests in it where it has changed.
   *
   * @param {Scene} scene
   */
  look({ clamp, eta, rise, length, y }) {
    // A rod that passes through the surface needs more room, and so does a stage that leaves it.
    this.above = Math.max(ABOVE, Math.max(...y) + rise - eta + HALF_CLAMP);
    const below = Math.max(0, -rise);
    this.scale = Math.min(this.height / (eta + this.above + below + BELOW), this.width / 1.15);
    const wide = this.width / this.scale;
    const place = (clamp - this.left) / wide;
    if (place < KEPT.from) this.left = clamp - KEPT.from * wide;
    if (place > KEPT.to) this.left = clamp - KEPT.to * wide;
    const key = [this.left, this.scale, this.width, this.height, eta, below, length].join();
    if (key === this.key) return;
    this.key = key;
    const top = this.above * this.scale;
    set(this.surface, { d: `M0 ${top}H${this.width}` });
    const gap = 14;
    const shift = ((this.left * this.scale) % gap) + gap;
    let hatch = "";
    for (let px = -shift; px < this.width + gap; px += gap) hatch += `M${px} ${top}l9 -9`;
    set(this.hatch, { d: hatch });
    this.drawRuler(top + (eta + below + 1.2 * HALF_CLAMP) * this.scale, length);
  }

  /**
   * @param {number} y
   * @param {number} length
   */
  drawRuler(y, length) {
    this.ruler.replaceChildren();
    drawn(this.ruler, "path", { d: `M0 ${y}H${this.width}` });
    const [from, to] = [length * this.left, length * (this.left + this.width / this.scale)];
    const { values, digits } = ticks(from, to, Math.max(3, this.width / 90));
    for (const value of values) {
      const x = this.x(value / length);
      drawn(this.ruler, "path", { d: `M${x} ${y}v5` });
      if (x < 16 || x > this.width - 16) continue;
      drawn(this.ruler, "text", { x, y: y + 18, class: "middle" }).textContent = spelled(
        value,
        digits,
      );
    }
  }

  /**
   * The rod's outline: its points, moved to both sides by half of its diameter.
   *
   * @param {Scene} scene
   * @param {(y: number) => number} up
   * @returns {string}
   */
  outline({ theta, s, x, y, clamp, side }, up) {
    const last = s.length - 1;
    /** @type {number[][]} */
    const [ax, ay, bx, by] = [[], [], [], []];
    const base = Math.max(HALF_BASE * this.scale, 3);
    for (let i = 0; i <= last; i += 1) {
      const [before, after] = [Math.max(0, i - 1), Math.min(last, i + 1)];
      const [dx, dy] = [side * (x[after] - x[before]), y[after] - y[before]];
      const half = (base * (1 - (1 - 1 / theta) * s[i])) / (Math.hypot(dx, dy) || 1);
      const [px, py] = [this.x(clamp + side * x[i]), up(y[i])];
      ax.push(px - half * dy);
      ay.push(py - half * dx);
      bx.unshift(px + half * dy);
      by.unshift(py + half * dx);
    }
    return `${pathThrough(ax.concat(bx), ay.concat(by))}Z`;
  }

  /**
   * @param {{ x: Float64Array, y: Float64Array, clamp: number, side: number }} shape
   * @param {(y: number) => number} up
   * @returns {string}
   */
  line({ x, y, clamp, side }, up) {
    return pathThrough(
      x.map((value) => this.x(clamp + side * value)),
      y.map(up),
    );
  }

  /**
   * The force of the surface on the rod, and the cone in which friction can hold it.
   *
   * @param {Scene} scene
   * @param {number} x
   * @param {number} top
   */
  drawForce({ fx, fy, mu0, unit, side }, x, top) {
    const reach = CONE * this.scale;
    const half = Math.atan(mu0);
    const [wx, wy] = [reach * Math.sin(half), reach * Math.cos(half)];
    const arc = `A${reach} ${reach} 0 0 0 ${x + wx} ${top + wy}`;
    set(this.cone, { d: `M${x} ${top}L${x - wx} ${top + wy}${arc}Z` });
    const length = (ARROW * this.scale) / unit;
    const longest = Math.min(1, (1.9 * ARROW * this.scale) / (length * Math.hypot(fx, fy)));
    const [dx, dy] = [side * fx * length * longest, -fy * length * longest];
    const size = 7 / (Math.hypot(dx, dy) || 1);
    const [tx, ty] = [x + dx, top + dy];
    const [hx, hy] = [dx * size, dy * size];
    const head = `M${tx - hx + 0.5 * hy} ${ty - hy - 0.5 * hx}L${tx} ${ty}`;
    const other = `L${tx - hx - 0.5 * hy} ${ty - hy + 0.5 * hx}`;
    set(this.arrow, { d: `M${x} ${top}L${tx} ${ty}${head}${other}` });
  }
}
