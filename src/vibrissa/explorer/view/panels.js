// The plots beside the rod: sticking curve, clamp forces, map of regimes, energy.

import { displacement } from "../solver/arm.js";
import { Plot } from "./plot.js";
import { spelled } from "./svg.js";

/** @import { Curve } from "../solver/path.js" */
/** @import { Sticking } from "../solver/motion.js" */
/** @import { Division } from "../solver/regimes.js" */
/** @import { Recording } from "./recording.js" */
/** @import { Settings } from "./settings.js" */
/** @import { Units } from "./units.js" */

/**
 * One row of what was read at the clamp; a row of NaN lifts the pen.
 *
 * @typedef {object} Reading
 * @property {number} clamp
 * @property {number} fx
 * @property {number} fy
 * @property {number} m
 */

/**
 * All that the plots show.
 *
 * @typedef {object} View
 * @property {Settings} settings
 * @property {Units} units
 * @property {Sticking} sticking
 * @property {Curve} curve
 * @property {number} x0
 * @property {Reading & { demand: number, energy: number, side: number }} now
 * @property {Reading[]} trace
 * @property {Recording | null} recording
 * @property {Division[]} divisions
 */

const RADIUS = 5;
const SMALL = 3.5;

/** −tan α over x0, with what friction allows. */
export class StickingPlot {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.plot = new Plot(svg, { across: true });
    /** @type {Curve | null} */
    this.drawn = null;
  }

  /** @param {View} view */
  show({ settings, units, sticking, curve, x0, now }) {
    const { plot } = this;
    const { path } = sticking;
    const length = units.scale.length;
    const known = Number.isFinite(path.muLock) ? path.muLock : 1;
    const top = 1.22 * Math.max(Math.min(known, 2.5), settings.mu0);
    const fresh = plot.setFrame({
      left: length * Math.max(path.x0Pulled, -0.15 * path.x0End),
      right: 1.03 * length * path.x0End,
      low: -0.3 * top,
      high: top,
    });
    const { left, right } = plot.frame;
    plot.line("zero", [left, right], [0, 0]);
    plot.line("friction", [left, right], [settings.mu0, settings.mu0]);
    plot.line("friction2", [left, right], [-settings.mu0, -settings.mu0]);
    if (fresh || curve !== this.drawn) {
      const demands = curve.x0.map((_, i) => curve.fx[i] / curve.fy[i]);
      plot.line("curve", curve.x0.map((value) => length * value), demands);
    }
    this.drawn = curve;
    plot.label("note", right, settings.mu0, `μ0 = ${spelled(settings.mu0, 3)}`, { dy: -5, end: true });
    const lock = path.lock ? length * displacement(path.branch, path.lock.state) : NaN;
    plot.mark("lock", lock, path.muLock, SMALL);
    plot.label("note2", lock, path.muLock, `μ_lock ${spelled(path.muLock, 4)}`, { dx: 4, dy: -7 });
    const slips = sticking.highBy === "slips";
    const slip = slips ? length * sticking.high : NaN;
    plot.line("onset", [slip, slip], [0, settings.mu0]);
    plot.mark("onsetmark", slip, settings.mu0, SMALL);
    const step = slips ? length * lastStep(sticking.high, settings.dx0) : NaN;
    plot.line("level", [step, step], [-0.05 * top, 0.05 * top]);
    plot.label("note3", step, 0, "x0,max", { dx: 4, dy: 13 });
    plot.mark("now", length * x0, now.demand, RADIUS);
  }
}

/**
 * The last multiple of a step that an onset does not pass.
 *
 * @param {number} onset
 * @param {number} step
 * @returns {number}
 */
export function lastStep(onset, step) {
  // An onset is known to about 1e-12: a step that ends on it counts.
  return Math.floor((onset + 1e-12) / step) * step;
}

/** One of the clamp's readings over its position. */
export class SignalPlot {
  /**
   * @param {SVGSVGElement} svg
   * @param {"fx" | "fy" | "m"} name
   * @param {boolean} across
   */
  constructor(svg, name, across) {
    this.plot = new Plot(svg, { across });
    this.name = name;
  }

  /** @param {View} view */
  show({ units, sticking, curve, now, trace, recording }) {
    const { plot, name } = this;
    const factor = units.scale[name === "m" ? "moment" : "force"];
    const length = units.scale.length;
    const places = [...trace.map((row) => row.clamp), ...(recording?.clamp ?? [])].filter(Number.isFinite);
    const [first, last] = [Math.min(0, ...places), Math.max(0.3, ...places)];
    const values = curve[name].filter(
      (_, i) => curve.x0[i] >= sticking.low && curve.x0[i] <= sticking.high,
    );
    if (name !== "fy" && trace.some((row) => name in row && row.fx > 0)) {
      values.push(...values.map((value) => -value));
    }
    // On an oblique stage each period has a path of its own.
    values.push(...trace.map((row) => row[name]));
    values.push(...(recording?.[name] ?? []).filter(Number.isFinite), ...(name === "fy" ? [] : [0]));
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const pad = 0.1 * (high - low || 1);
    plot.setFrame({
      left: length * 0.1 * Math.floor(10 * first),
      right: length * 0.1 * Math.ceil(10 * last),
      low: factor * (low - pad),
      high: factor * (high + pad),
    });
    plot.line("zero", [plot.frame.left, plot.frame.right], [0, 0]);
    plot.line(
      "measured",
      (recording?.clamp ?? []).map((value) => length * value),
      (recording?.[name] ?? []).map((value) => factor * value),
    );
    plot.line(
      "curve",
      trace.map((row) => length * row.clamp),
      trace.map((row) => factor * row[name]),
    );
    plot.mark("now", length * now.clamp, factor * now[name], RADIUS - 1);
  }
}

/** What a tip does, over taper and friction. */
export class RegimePlot {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.plot = new Plot(svg, { across: true });
    /** What is drawn already. */
    this.drawn = "";
  }

  /** @param {View} view */
  show({ settings, divisions }) {
    const { plot } = this;
    const locks = divisions.map(({ lock }) => lock).filter(Number.isFinite);
    const top = Math.max(0.6, 1.3 * settings.mu0, Math.min(2, 1.35 * Math.max(0, ...locks)));
    const fresh = plot.setFrame({ left: 1, right: settings.theta > 8 ? 20 : 8, low: 0, high: Math.ceil(10 * top) / 10 });
    plot.mark("now", settings.theta, settings.mu0, RADIUS);
    const key = `${divisions.length} ${settings.contact} ${divisions[0]?.lock}`;
    if (!fresh && key === this.drawn) return;
    this.drawn = key;
    const { high } = plot.frame;
    const theta = divisions.map((row) => row.theta);
    const lock = divisions.map((row) => row.lock);
    const touch = divisions.map(({ touch, lock }) => (touch < lock ? touch : lock));
    plot.area("locks", theta, lock, high);
    plot.area("slips", theta, touch, 0);
    plot.line("edge", theta, touch);
    plot.line("curve", theta, lock);
    const edge = divisions.map(({ lock }) => Math.min(high, lock));
    const line = settings.contact === "line";
    this.named("name", "locks", theta, edge, edge.map(() => high));
    this.named("name2", "slips", theta, touch.map(() => 0), touch, 0.16);
    this.named("name3", line ? "lies, slips" : "passes through, slips", theta, touch, edge);
  }

  /**
   * Write a region's name where it is tallest.
   *
   * @param {string} part
   * @param {string} name
   * @param {number[]} theta
   * @param {number[]} low
   * @param {number[]} high
   * @param {number} [from] Part of the plot's width from which on it may stand.
   */
  named(part, name, theta, low, high, from = 0.4) {
    const { plot } = this;
    // A name needs room to both sides.
    const { right } = plot.frame;
    const inside = theta
      .map((_, i) => i)
      .filter((i) => theta[i] >= from * right && theta[i] <= (from + 0.25) * right);
    const tall = (/** @type {number} */ i) => high[i] - low[i] || 0;
    const best = inside.reduce((a, b) => (tall(b) > 1.02 * tall(a) ? b : a), inside[0] ?? -1);
    const room = best < 0 ? 0 : plot.y(low[best]) - plot.y(high[best]);
    const y = room > 22 ? 0.5 * (low[best] + high[best]) : NaN;
    plot.label(part, theta[best] ?? NaN, y, name, { dy: 4 });
  }
}

/** Bending energy over x0. */
export class EnergyPlot {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.plot = new Plot(svg, { across: true });
    /** @type {Curve | null} */
    this.drawn = null;
  }

  /** @param {View} view */
  show({ units, sticking, curve, x0, now }) {
    const { plot } = this;
    const [length, factor] = [units.scale.length, units.scale.energy];
    const { low, high } = sticking;
    const right = high + 0.25 * (high - low);
    const seen = curve.energy.filter((_, i) => curve.x0[i] >= low && curve.x0[i] <= right);
    const [least, most] = [Math.min(...seen, now.energy), Math.max(...seen, now.energy)];
    const fresh = plot.setFrame({
      left: length * low,
      right: length * right,
      low: factor * (least - 0.12 * (most - least)),
      high: factor * (most + 0.12 * (most - least)),
    });
    if (fresh || curve !== this.drawn) {
      const energies = curve.energy.map((value) => factor * value);
      plot.line("curve", curve.x0.map((value) => length * value), energies);
    }
    this.drawn = curve;
    plot.line("onset", [length * high, length * high], [plot.frame.low, plot.frame.high]);
    plot.mark("now", length * x0, factor * now.energy, RADIUS);
  }
}
