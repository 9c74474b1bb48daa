// The plots beside the rod: friction required to stick, load on the clamp, map of regimes, energy.

import { displacement } from "../solver/arm.js";
import { heightOf } from "../solver/wave.js";
import { Plot } from "./plot.js";
import { lastStep, onsetOf } from "./readouts.js";
import { MOST_SLIPS } from "./model.js";
import { MOST_PINS, waveOf } from "./settings.js";
import { set, significant, spelled, withoutNoise, write } from "./svg.js";
import { scaled } from "./units.js";
import { rodName } from "./words.js";

const RADIUS = 5;
const SMALL = 3.5;
/** Length (L) and least and largest number of the waves that are drawn; points of each. */
const WAVES_LENGTH = 0.2;
const [LEAST_WAVES, MOST_WAVES] = [3, 24];
const WAVE_PARTS = 40;

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
    const { ahead, behind } = sticking;
    const { length } = units.scale;
    const peaks = [path.muLock, ...pins.map(({ muLock }) => muLock)];
    const ends = [path.x0End, ...pins.map(({ curve }) => curve.x0[curve.x0.length - 1])];
    const top = 1.22 * Math.max(Math.min(ahead, 2.5), ...peaks.map((peak) => (Number.isFinite(peak) ? Math.min(peak, 2.5) : 1)));
    // A pulled tip needs room; the frame stays as it is while the tip sticks and slips.
    const pulled = trace.some(({ x0 }) => withoutNoise(x0) < 0);
    plot.setFrame({
      left: length * Math.max(path.x0Pulled, Math.min(-0.15 * path.x0End, pulled ? 1.1 * sticking.low : 0)),
      right: 1.03 * length * Math.max(...ends),
      low: -Math.max(0.3 * top, pulled ? 1.1 * Math.min(-behind, 2.5) : 0),
      high: top,
    });
    plot.axes = { x: ["x0", units.name.length], y: ["−tan α", ""] };
    const { left, right } = plot.frame;
    plot.line("zero", [left, right], [0, 0]);
    plot.line("friction", [left, right], [ahead, ahead]);
    plot.line("friction2", [left, right], [behind, behind]);
    this.showPins(pins, length);
    plot.line("curve", scaled(curve.x0, length), curve.demand);
    plot.mark("handle", right, ahead, RADIUS);
    const slope = waveOf(settings) ? " on the slope" : "";
    plot.label("note", right, ahead, `μ0 = ${spelled(mu0, 3)}${slope}`, { dx: 9, dy: -7, end: true });
    const lock = path.lock ? length * displacement(path.branch, path.lock.state) : NaN;
    plot.mark("lock", lock, path.muLock, SMALL);
    plot.label("note2", lock, path.muLock, `μ_lock = ${spelled(path.muLock, 4)}`, { dx: 4, dy: -7 });
    const slip = length * onsetOf(sticking);
    plot.line("onset", [slip, slip], [0, ahead]);
    plot.mark("onsetmark", slip, ahead, SMALL);
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

/** The wave around the tip, with magnified heights, and the places at which the last slips ended. */
export class WavePlot {
  /**
   * @param {SVGSVGElement} svg
   * @param {HTMLElement} caption
   */
  constructor(svg, caption) {
    this.plot = new Plot(svg, true);
    this.caption = caption;
  }

  /** @param {View} view */
  show({ settings, units, now, rests, slipsInWave }) {
    const { plot } = this;
    const wave = waveOf(settings);
    if (!wave) return;
    const { amplitude, wavelength } = wave;
    const { length } = units.scale;
    /** Distance from the clamp's level. @param {number} x */
    const level = (x) => length * (settings.eta - heightOf(wave, x));
    const waves = Math.min(MOST_WAVES, Math.max(LEAST_WAVES, Math.ceil(WAVES_LENGTH / wavelength - 1e-9)));
    // The window moves by whole waves.
    const first = wavelength * (Math.floor(now.contact / wavelength) - waves + 2);
    const last = first + waves * wavelength;
    plot.axes = { x: ["x", units.name.length], y: ["η − h", units.name.length] };
    const high = length * (settings.eta + 1.6 * amplitude);
    plot.setFrame({ left: length * first, right: length * last, low: length * (settings.eta - 1.6 * amplitude), high });
    const x = Array.from({ length: waves * WAVE_PARTS + 1 }, (_, k) => first + (k * wavelength) / WAVE_PARTS);
    plot.area("material", x.map((at) => length * at), x.map(level), high);
    plot.line("profile", x.map((at) => length * at), x.map(level));
    for (let i = 0; i <= MOST_SLIPS; i += 1) {
      const at = rests[i] ?? NaN;
      plot.mark(`rest${i}`, length * at, level(at), SMALL);
    }
    plot.mark("now", length * now.contact, level(now.contact), RADIUS);
    const [along, up] = [plot.x(1) - plot.x(0), plot.y(0) - plot.y(1)];
    const counted = rests.length - 1;
    const slips = counted > 0 ? `${spelled(slipsInWave, 2)} slips in a wave (the last ${counted})` : "fewer than two slips";
    const scale = Number((up / along).toPrecision(2));
    write(this.caption, `${slips}; circles: places of rest; heights magnified ${scale} times`);
  }
}
