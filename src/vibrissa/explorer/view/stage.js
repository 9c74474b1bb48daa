// The rod between its clamp and the surface, with the force in its friction cone.

import { heightOf, slopeOf } from "../solver/wave.js";
import { waveOf } from "./settings.js";
import { drawn, Parts, pathThrough, set, spelled, ticks } from "./svg.js";

/** Half of the base's diameter, and half of the clamp's width, both exaggerated (L). */
const HALF_BASE = 0.016;
const HALF_CLAMP = 0.045;
/** Room above the surface, below the clamp and to both sides (L); the ruler's depth below the clamp. */
const ABOVE = 0.12;
const BELOW = 0.25;
const BESIDE = 0.12;
const RULER = 0.15;
/** Range of the clamp's position in the window, as fractions of its width; the whole rod has priority. */
const KEPT = { from: 0.2, to: 0.55 };
const ARROW = 0.25;
const CONE = 0.3;
/** Longest arrow of a force, in arrows of the force at α = 0: longer ones are drawn at a smaller scale. */
const LONGEST = 2.4;
/** Pixels from the surface to the dimension line of a slip. */
const JUMP = 16;
/** Pixels from point to point of a wave, and its points in a wavelength. */
const WAVE_PIXELS = 3;
const WAVE_POINTS = 24;
const RADIAN = Math.PI / 180;

/** A line between two lines. @type {(from: Line, to: Line, part: number) => Line} */
function mixed(from, to, part) {
  return {
    x: to.x.map((value, i) => from.x[i] + part * (value - from.x[i])),
    y: to.y.map((value, i) => from.y[i] + part * (value - from.y[i])),
  };
}

export class Stage {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.svg = svg;
    this.parts = new Parts(svg);
    // From back to front.
    for (const name of ["hatch", "surface", "cone", "rail"]) this.parts.part(name, "path");
    this.ruler = drawn(svg, "g", { class: "ruler" });
    for (const name of ["slipped", "ghost", "rod", "beyond", "arrow"]) this.parts.part(name, "path");
    this.labels = new Parts(drawn(svg, "g", { class: "labels" }));
    this.contact = drawn(svg, "circle", { class: "contact", r: 6 });
    this.clamp = drawn(svg, "g", { class: "clamp", tabindex: 0, role: "slider", "aria-label": "Clamp" });
    set(this.clamp, { "aria-valuemin": -5, "aria-valuemax": 50 });
    this.body = drawn(this.clamp, "path");
    this.grip = drawn(this.clamp, "path", { class: "grip" });
    this.width = 600;
    this.height = 400;
    this.scale = 300;
    this.top = 40;
    this.left = 0;
    this.key = "";
  }

  /** Take over the size of the drawing on the page. */
  resize() {
    this.width = this.svg.clientWidth || this.width;
    this.height = this.svg.clientHeight || this.height;
    set(this.svg, { viewBox: `0 0 ${this.width} ${this.height}` });
    this.labels.width = this.width;
    this.key = "";
  }

  /** @type {(x: number) => number} */
  x(x) {
    return (x - this.left) * this.scale;
  }

  /** @param {Scene} scene */
  show(scene) {
    const { settings, now, shape, first, facing, jump } = scene;
    const { eta, theta, beta, delta } = settings;
    const { side } = now;
    const [cos, sin] = [Math.cos(delta * RADIAN), Math.sin(delta * RADIAN)];
    const begun = now.clamp - side * now.x0;
    /** @type {(shape: Line, clamp: number, way: number) => Line} */
    const at = ({ x, y }, clamp, way) => ({
      x: x.map((value) => cos * clamp + way * value),
      y: y.map((value) => sin * clamp + value),
    });
    const after = at(shape, now.clamp, facing);
    const rod = jump && jump.part < 1 ? mixed(jump.before, after, jump.part) : after;
    const ghost = at(first, begun, side);
    const [clamp, rise] = [cos * now.clamp, sin * now.clamp];
    this.look(scene, rod, clamp, rise);
    /** @param {number} y */
    const up = (y) => this.top + (eta - y) * this.scale;
    this.labels.taken.clear();
    /** @param {Line} line */
    const pixels = (line) => ({ x: line.x.map((value) => this.x(value)), y: line.y.map(up) });
    const [shown, old] = [pixels(rod), pixels(ghost)];
    const wave = waveOf(settings);
    const crest = this.top - (wave ? wave.amplitude * this.scale : 0);
    // No real rod passes through the surface.
    const above = shown.y.findIndex((y) => y < crest - 1);
    const real = above < 0 ? shape.s.length : above + 1;
    const part = { x: shown.x.subarray(0, real), y: shown.y.subarray(0, real) };
    this.parts.path("rod", this.outline(theta, shape.s.subarray(0, real), part));
    this.parts.path("beyond", above < 0 ? "M0 0" : pathThrough(shown.x.subarray(above), shown.y.subarray(above)));
    this.parts.path("ghost", pathThrough(old.x, old.y));
    const slipped = jump ? pixels(jump.before) : null;
    this.parts.path("slipped", slipped ? pathThrough(slipped.x, slipped.y) : "M0 0");
    const base = { x: this.x(clamp), y: up(rise) };
    this.drawClamp(base, side * beta);
    const slope = Math.tan(delta * RADIAN);
    const under = 1.2 * HALF_CLAMP * this.scale;
    const rail = [0, this.width].map((x) => base.y + under - slope * (x - base.x));
    this.parts.path("rail", delta === 0 ? "M0 0" : `M0 ${rail[0]}L${this.width} ${rail[1]}`);
    // If the rod lies on the surface, the contact point is at s_c, before the tip.
    const lift = wave ? heightOf(wave, now.contact) : 0;
    const contact = { x: this.x(now.contact - side * (1 - now.sc)), y: this.top + lift * this.scale };
    set(this.contact, { cx: contact.x, cy: contact.y });
    this.contact.classList.toggle("slides", scene.slides);
    const force = this.drawForce(scene, contact);
    set(this.labels.parent, { visibility: settings.labels === "on" ? "visible" : "hidden" });
    if (settings.labels === "off") return;
    this.nameForce(settings, contact, force);
    this.nameJump(jump);
    this.nameLengths(settings, base, { x: this.x(cos * begun), y: up(sin * begun) }, old, side);
  }

  /**
   * Fit the window to the rod, and let it follow the clamp; draw surface and ruler if the window has changed.
   * @type {(scene: Scene, rod: { x: Float64Array, y: Float64Array }, clamp: number, rise: number) => void}
   */
  look({ settings, length }, { x, y }, clamp, rise) {
    const { eta } = settings;
    // A rod that would penetrate the surface needs more room, and so does a stage that leaves it.
    const above = Math.max(ABOVE, Math.max(...y) - eta + HALF_CLAMP);
    const below = Math.max(0, -rise);
    const [from, to] = [Math.min(clamp, ...x) - BESIDE, Math.max(clamp, ...x) + BESIDE];
    // Wide enough for the reach of the rod, so that the scale stays constant while the clamp moves.
    const reach = Math.sqrt(1 - eta ** 2) + 0.3 + 2 * BESIDE;
    const tall = eta + above + below + BELOW;
    this.scale = Math.min(this.height / tall, this.width / Math.max(reach, to - from));
    this.top = above * this.scale + 0.5 * (this.height - tall * this.scale);
    const wide = this.width / this.scale;
    this.left = Math.max(clamp - KEPT.to * wide, Math.min(clamp - KEPT.from * wide, this.left));
    this.left = Math.max(to - wide, Math.min(from, this.left));
    const wave = waveOf(settings);
    const waves = wave ? [wave.amplitude, wave.wavelength] : [];
    const key = [this.left, this.scale, this.width, this.height, eta, above, below, length, ...waves].join();
    if (key === this.key) return;
    this.key = key;
    this.parts.path("surface", wave ? this.outlineOf(wave) : `M0 ${this.top}H${this.width}`);
    const gap = 14;
    const shift = ((this.left * this.scale) % gap) + gap;
    let hatch = "";
    for (let px = -shift; px < this.width + gap; px += gap) hatch += `M${px} ${this.top}l9 -9`;
    this.parts.path("hatch", hatch);
    this.drawRuler(this.top + (eta + below + RULER) * this.scale, length);
  }

  /** Outline of a wave, true to scale. @param {Wave} wave */
  outlineOf(wave) {
    const step = Math.min(WAVE_PIXELS / this.scale, wave.wavelength / WAVE_POINTS);
    const count = Math.ceil(this.width / this.scale / step);
    const x = Array.from({ length: count + 1 }, (_, k) => this.left + k * step);
    return pathThrough(x.map((at) => this.x(at)), x.map((at) => this.top + heightOf(wave, at) * this.scale));
  }

  /** @type {(y: number, length: number) => void} */
  drawRuler(y, length) {
    this.ruler.replaceChildren();
    drawn(this.ruler, "path", { d: `M0 ${y}H${this.width}` });
    const [from, to] = [length * this.left, length * (this.left + this.width / this.scale)];
    const { values, digits } = ticks(from, to, Math.max(3, this.width / 90));
    for (const value of values) {
      const x = this.x(value / length);
      drawn(this.ruler, "path", { d: `M${x} ${y}v5` });
      if (x < 16 || x > this.width - 16) continue;
      const text = drawn(this.ruler, "text", { x, y: y + 18, "text-anchor": "middle" });
      text.textContent = spelled(value, digits);
    }
  }

  /** @type {(base: { x: number, y: number }, lean: number) => void} */
  drawClamp({ x, y }, lean) {
    const half = HALF_CLAMP * this.scale;
    const transform = `rotate(${-lean} ${x} ${y})`;
    set(this.body, { transform, d: `M${x - half} ${y}h${2 * half}v${1.2 * half}h${-2 * half}z` });
    const lines = [-half / 3, 0, half / 3].map((d) => `M${x + d} ${y + 0.35 * half}v${0.5 * half}`);
    set(this.grip, { transform, d: lines.join("") });
  }

  /**
   * The rod's outline: its points, moved to both sides by half of its diameter.
   * @type {(theta: number, s: Float64Array, line: { x: Float64Array, y: Float64Array }) => string}
   */
  outline(theta, s, { x, y }) {
    const last = s.length - 1;
    /** @type {number[][]} */
    const [ax, ay, bx, by] = [[], [], [], []];
    const base = Math.max(HALF_BASE * this.scale, 3);
    for (let i = 0; i <= last; i += 1) {
      const [before, after] = [Math.max(0, i - 1), Math.min(last, i + 1)];
      const [dx, dy] = [x[after] - x[before], y[after] - y[before]];
      const half = (base * (1 - (1 - 1 / theta) * s[i])) / (Math.hypot(dx, dy) || 1);
      ax.push(x[i] + half * dy);
      ay.push(y[i] - half * dx);
      bx.unshift(x[i] - half * dy);
      by.unshift(y[i] + half * dx);
    }
    return `${pathThrough(ax.concat(bx), ay.concat(by))}Z`;
  }

  /**
   * Draw the force of the surface on the rod, and the friction cone; returns the end of the arrow. A large force is
   * drawn at half of the usual scale, or at a quarter, ...: `share` is 2, 4, ...
   * @type {(scene: Scene, contact: Point) => Point & { share: number }}
   */
  drawForce({ settings, now, unit }, { x, y }) {
    const { mu0 } = settings;
    const wave = waveOf(settings);
    // The cone stands on the slope of the surface.
    const turn = wave ? Math.atan(slopeOf(wave, now.contact)) / RADIAN : 0;
    const reach = CONE * this.scale;
    const half = Math.atan(mu0);
    const [wx, wy] = [reach * Math.sin(half), reach * Math.cos(half)];
    const arc = `A${reach} ${reach} 0 0 0 ${x + wx} ${y + wy}`;
    this.parts.path("cone", `M${x} ${y}L${x - wx} ${y + wy}${arc}Z`);
    set(this.parts.part("cone", "path"), { transform: `rotate(${turn} ${x} ${y})` });
    const size0 = Math.hypot(now.fx, now.fy) / unit;
    const share = 2 ** Math.max(0, Math.ceil(Math.log2(size0 / LONGEST)));
    const length = (ARROW * this.scale) / (unit * share);
    const [dx, dy] = [now.fx * length, -now.fy * length];
    const size = 7 / (Math.hypot(dx, dy) || 1);
    const [tx, ty] = [x + dx, y + dy];
    const [hx, hy] = [dx * size, dy * size];
    const head = `M${tx - hx + 0.5 * hy} ${ty - hy - 0.5 * hx}L${tx} ${ty}`;
    const other = `L${tx - hx - 0.5 * hy} ${ty - hy + 0.5 * hx}`;
    this.parts.path("arrow", `M${x} ${y}L${tx} ${ty}${head}${other}`);
    return { x: tx, y: ty, share };
  }

  /** The length of the last slip, above the surface. @param {Jump | null} jump */
  nameJump(jump) {
    const [from, to] = jump ? [this.x(jump.from), this.x(jump.to)] : [0, 0];
    const y = this.top - JUMP;
    const seen = jump && Math.abs(to - from) > 3;
    this.labels.path("jump", seen ? `M${from} ${this.top}V${y - 4}M${to} ${this.top}V${y - 4}M${from} ${y}H${to}` : "M0 0");
    this.labels.text("jump-length", 0.5 * (from + to), y - 5, seen ? jump.text : "", "middle");
  }

  /**
   * Names of the force, of its inclination and of the friction cone.
   * @type {(settings: Settings, contact: Point, tip: Point & { share: number }) => void}
   */
  nameForce({ mu0 }, { x, y }, tip) {
    const { labels } = this;
    const alpha = Math.atan2(tip.x - x, tip.y - y);
    const way = Math.sign(alpha) || -1;
    const long = Math.hypot(tip.x - x, tip.y - y) > 14;
    const name = tip.share > 1 ? `f, scale 1:${tip.share}` : "f";
    labels.text("force", tip.x + 9 * way, tip.y + 4, long ? name : "", way < 0 ? "end" : "start");
    labels.path("line", `M${x} ${y}v${0.42 * this.scale}`);
    const radius = 0.36 * this.scale;
    const seen = Math.abs(alpha) > 0.06;
    const end = `${x + radius * Math.sin(alpha)} ${y + radius * Math.cos(alpha)}`;
    labels.path("arc", seen ? `M${x} ${y + radius}A${radius} ${radius} 0 0 ${alpha < 0 ? 1 : 0} ${end}` : "M0 0");
    const [ax, ay] = [Math.sin(0.5 * alpha), Math.cos(0.5 * alpha)];
    labels.text("alpha", x + (radius + 12) * ax, y + (radius + 12) * ay + 4, seen ? "α" : "", "middle");
    const half = Math.atan(mu0);
    const [cx, cy] = [CONE * this.scale * Math.sin(half), y + CONE * this.scale * Math.cos(half)];
    const fits = x + cx + 86 < this.width;
    labels.text("cone-name", fits ? x + cx + 5 : x - cx - 5, fits ? cy : cy + 14, "friction cone", fits ? "start" : "end");
  }

  /**
   * Names of the surface's height, of the displacement, of the stage's angle and of the rod at α = 0.
   * @type {(settings: Settings, base: { x: number, y: number }, begun: { x: number, y: number },
   *   ghost: { x: Float64Array, y: Float64Array }, side: number) => void}
   */
  nameLengths({ delta }, base, begun, ghost, side) {
    const { labels } = this;
    const edge = this.width - 16;
    labels.path("height", `M${edge} ${this.top}V${base.y}m-4 0h8M${edge - 4} ${this.top}h8M${base.x + 30} ${base.y}H${edge - 8}`);
    labels.text("eta", edge - 7, 0.5 * (this.top + base.y) + 4, "η", "end");
    const moved = Math.abs(base.x - begun.x) > 4;
    const y = base.y + 1.2 * HALF_CLAMP * this.scale + 8;
    const span = `M${begun.x} ${y}H${base.x}M${begun.x} ${y - 4}v8M${base.x} ${y - 4}v8M${begun.x} ${begun.y}V${y - 4}`;
    labels.path("displacement", moved ? span : "M0 0");
    const [left, right] = [Math.min(begun.x, base.x), Math.max(begun.x, base.x)];
    labels.text("x0", side > 0 ? left - 5 : right + 5, y + 4, moved ? "x0" : "", side > 0 ? "end" : "start");
    const i = Math.round(0.45 * ghost.x.length);
    labels.text("ghost-name", ghost.x[i] - 12 * side, ghost.y[i], moved ? "α = 0" : "", side > 0 ? "end" : "start");
    const reach = 0.36 * this.scale;
    const [bottom, turn] = [base.y + 1.2 * HALF_CLAMP * this.scale, delta * RADIAN];
    const arc = `A${reach} ${reach} 0 0 ${delta > 0 ? 0 : 1} ${base.x + reach * Math.cos(turn)} ${bottom - reach * Math.sin(turn)}`;
    const angle = `M${base.x} ${bottom}h${1.3 * reach}M${base.x + reach} ${bottom}${arc}`;
    labels.path("stage-angle", delta === 0 ? "M0 0" : angle);
    const name = delta === 0 ? "" : `δ = ${spelled(delta, 1)}°`;
    const beside = base.x + 1.3 * reach + 5;
    labels.text("delta", Math.min(beside, this.width - 6), bottom + 14, name, beside + 60 < this.width ? "start" : "end");
  }
}
