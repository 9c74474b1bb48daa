// The plots beside the rod: friction required to stick, load on the clamp, map of regimes, energy.

import { displacement } from "../solver/arm.js";
import { Plot } from "./plot.js";
import { lastStep, onsetOf } from "./readouts.js";
import { MOST_PINS } from "./settings.js";
import { set, significant, spelled, withoutNoise } from "./svg.js";
import { scaled } from "./units.js";
import { rodName } from "./words.js";

const RADIUS = 5;
const SMALL = 3.5;

/** Friction −tan α required to stick, over x0, with lines at ±μ0. */
export class StickingPlot {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.plot = new Plot(svg, true);
    const [, , handle, now] = ["lock", "onsetmark", "handle", "now"].map((name) => {
      return this.plot.content.part(name, "circle");
    });
    // Both can be dragged, or moved by keys.
    set(handle, { tabindex: 0, role: "slider", "aria-label": "μ0", "aria-valuemin": 0.02, "aria-valuemax": 2 });
    set(now, { tabindex: 0, role: "slider", "aria-label": "x0 on the curve" });
    this.sliders = { handle, now };
  }

  /** @param {View} view */
  show({ settings, units, sticking, curve, now, trace, pins }) {
    const { plot } = this;
    const { path } = sticking;
    const { mu0 } = settings;
    const { length } = units.scale;
    const peaks = [path.muLock, ...pins.map(({ muLock }) => muLock)];
    const ends = [path.x0End, ...pins.map(({ curve }) => curve.x0[curve.x0.length - 1])];
    const top = 1.22 * Math.max(mu0, ...peaks.map((peak) => (Number.isFinite(peak) ? Math.min(peak, 2.5) : 1)));
    // A pulled tip needs room; the frame stays as it is while the tip sticks and slips.
    const pulled = trace.some(({ x0 }) => withoutNoise(x0) < 0);
    plot.setFrame({
      left: length * Math.max(path.x0Pulled, Math.min(-0.15 * path.x0End, pulled ? 1.1 * sticking.low : 0)),
      right: 1.03 * length * Math.max(...ends),
      low: -Math.max(0.3 * top, pulled ? 1.1 * mu0 : 0),
      high: top,
    });
    plot.axes = { x: ["x0", units.name.length], y: ["−tan α", ""] };
    const { left, right } = plot.frame;
    plot.line("zero", [left, right], [0, 0]);
    plot.line("friction", [left, right], [mu0, mu0]);
    plot.line("friction2", [left, right], [-mu0, -mu0]);
    this.showPins(pins, length);
    plot.line("curve", scaled(curve.x0, length), curve.demand);
    plot.mark("handle", right, mu0, RADIUS);
    plot.label("note", right, mu0, `μ0 = ${spelled(mu0, 3)}`, { dx: 9, dy: -7, end: true });
    const lock = path.lock ? length * displacement(path.branch, path.lock.state) : NaN;
    plot.mark("lock", lock, path.muLock, SMALL);
    plot.label("note2", lock, path.muLock, `μ_lock = ${spelled(path.muLock, 4)}`, { dx: 4, dy: -7 });
    const slip = length * onsetOf(sticking);
    plot.line("onset", [slip, slip], [0, mu0]);
    plot.mark("onsetmark", slip, mu0, SMALL);
    const step = length * lastStep(onsetOf(sticking), settings.dx0);
    plot.line("level", [step, step], [-0.05 * top, 0.05 * top]);
    plot.label("note3", step, 0, "x0,max", { dx: 4, dy: 13 });
    plot.mark("now", length * now.x0, now.demand, RADIUS + 1);
    set(this.sliders.handle, { "aria-valuenow": mu0 });
    const text = `${significant(length * withoutNoise(now.x0))} ${units.name.length}`;
    const places = { "aria-valuemin": sticking.low, "aria-valuemax": sticking.high, "aria-valuenow": now.x0 };
    set(this.sliders.now, { ...places, "aria-valuetext": text });
  }

  /** @type {(pins: Pin[], length: number) => void} */
  showPins(pins, length) {
    const { plot } = this;
    for (let i = 0; i < MOST_PINS; i += 1) {
      const pin = pins[i];
      const x = pin ? scaled(pin.curve.x0, length) : [];
      plot.line(`pinned pin-${"abc"[i]}`, x, pin ? pin.curve.demand : []);
      const y = plot.height - plot.margin.bottom - 8 - 15 * (pins.length - 1 - i);
      const name = pin ? `pinned: ${rodName(pin.settings)}` : "";
      plot.content.text(`pinname pin-${"abc"[i]}`, plot.width - plot.margin.right - 4, y, name, "end");
    }
  }
}

/** One of the clamp's readings over its position. */
export class SignalPlot {
  /**
   * @param {SVGSVGElement} svg
   * @param {"fx" | "fy" | "m"} name
   * @param {boolean} across
   */
  constructor(svg, name, across) {
    this.plot = new Plot(svg, across);
    this.name = name;
  }

  /** @param {View} view */
  show({ units, sticking, curve, now, trace, recording }) {
    const { plot, name } = this;
    const quantity = name === "m" ? "moment" : "force";
    const { length, [quantity]: factor } = units.scale;
    const symbol = { fx: "Fx", fy: "Fy", m: "M" }[name];
    plot.axes = { x: ["clamp", units.name.length], y: [symbol, units.name[quantity]] };
    const places = [...trace.map((row) => row.clamp), ...(recording?.clamp ?? [])].filter(Number.isFinite);
    const [first, last] = [Math.min(0, ...places), Math.max(0.3, ...places)];
    const { low: from, high: to } = sticking;
    const values = curve[name].filter((_, i) => curve.x0[i] >= from && curve.x0[i] <= to);
    if (name !== "fy" && trace.some((row) => row.fx > 0)) values.push(...values.map((value) => -value));
    // On an oblique stage each period has another path.
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
    plot.line("measured", scaled(recording?.clamp ?? [], length), scaled(recording?.[name] ?? [], factor));
    plot.line("curve", trace.map((row) => length * row.clamp), trace.map((row) => factor * row[name]));
    plot.mark("now", length * now.clamp, factor * now[name], RADIUS - 1);
  }
}

/** Regimes of the tip, over taper and friction. */
export class RegimePlot {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.plot = new Plot(svg, true);
    this.plot.axes = { x: ["θ", ""], y: ["μ_lock", ""] };
  }

  /** @param {View} view */
  show({ settings, divisions }) {
    const { plot } = this;
    const theta = divisions.map((row) => row.theta);
    const lock = divisions.map((row) => row.lock);
    const top = Math.max(0.6, 1.3 * settings.mu0, Math.min(2, 1.35 * Math.max(0, ...lock.filter(Number.isFinite))));
    const right = settings.theta > 8 ? 20 : 8;
    plot.setFrame({ left: 1, right, low: 0, high: Math.ceil(10 * top) / 10 });
    plot.mark("now", settings.theta, settings.mu0, RADIUS);
    const touch = divisions.map(({ touch, lock }) => (touch < lock ? touch : lock));
    plot.area("locks", theta, lock, plot.frame.high);
    plot.area("slips", theta, touch, 0);
    plot.line("edge", theta, touch);
    plot.line("curve", theta, lock);
    plot.label("name", 1, plot.frame.high, "locks", { dx: 5, dy: 14 });
    plot.label("name2", 1, 0, "slips", { dx: 5, dy: -6 });
  }
}

/** Bending energy over x0. */
export class EnergyPlot {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.plot = new Plot(svg, true);
  }

  /** @param {View} view */
  show({ units, sticking, curve, now }) {
    const { plot } = this;
    const { length, energy: factor } = units.scale;
    plot.axes = { x: ["x0", units.name.length], y: ["energy", units.name.energy] };
    const { low, high } = sticking;
    const right = high + 0.25 * (high - low);
    const seen = curve.energy.filter((_, i) => curve.x0[i] >= low && curve.x0[i] <= right);
    const [least, most] = [Math.min(...seen, now.energy), Math.max(...seen, now.energy)];
    plot.setFrame({
      left: length * low,
      right: length * right,
      low: factor * (least - 0.12 * (most - least)),
      high: factor * (most + 0.12 * (most - least)),
    });
    plot.line("curve", scaled(curve.x0, length), scaled(curve.energy, factor));
    plot.line("onset", [length * high, length * high], [plot.frame.low, plot.frame.high]);
    plot.mark("now", length * now.x0, factor * now.energy, RADIUS);
  }
}
