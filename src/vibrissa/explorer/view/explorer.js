// The page: what a user does moves the model, and each frame shows where it is.

import { divisions } from "../solver/regimes.js";
import { force, inclination } from "../solver/rod/state.js";
import { Controls, element } from "./controls.js";
import { asCsv } from "./exports.js";
import { listenToClamp, listenToFiles, listenToMap } from "./hands.js";
import { Model } from "./model.js";
import { EnergyPlot, lastStep, RegimePlot, SignalPlot, StickingPlot } from "./panels.js";
import { fromAddress, MOUNTING_NUMBERS, mountingOf, toAddress } from "./settings.js";
import { Stage } from "./stage.js";
import { set, significant, spelled, withoutNoise, write } from "./svg.js";
import { NONDIMENSIONAL, unitsOf } from "./units.js";
import { condition, mounted, told } from "./words.js";

/** @import { Event } from "../solver/motion.js" */
/** @import { Division } from "../solver/regimes.js" */
/** @import { Settings } from "./settings.js" */
/** @import { Quantity } from "./units.js" */

/** Points of the drawn rod. */
const POINTS = 81;
/** Milliseconds of a frame that the map of regimes may take, and after which words may change. */
const BUDGET = 5;
const PATIENCE = 350;
/** Milliseconds after which the address follows. */
const ADDRESS_AFTER = 300;
/** Tapers of the map: up to 8, or up to 20 where the rod itself has more. */
const TAPERS = Array.from({ length: 29 }, (_, k) => 1 + 0.25 * k);
const MORE_TAPERS = Array.from({ length: 39 }, (_, k) => 1 + 0.5 * k);
/** Milliseconds between two steps of a clamp that moves by itself, and where motion is reduced. */
const PACE = 1000 / 60;
const SLOW_PACE = 250;

/** @type {Event["what"][]} */
const ENDS = ["swings", "snaps", "slips back", "lifts", "inadmissible", "unknown"];

/**
 * A named choice of settings.
 *
 * @typedef {object} Preset
 * @property {string} name
 * @property {string} note
 * @property {Partial<Settings>} settings
 * @property {number} clamp
 * @property {boolean} play
 * @property {import("./recording.js").Recording | null} recording
 */

/** @type {[string, string, Quantity][]} */
const READOUTS = [
  ["clamp", "position of the clamp", "length"],
  ["x0", "x0 on the sticking curve", "length"],
  ["slip", "exact onset x0,slip", "length"],
  ["step", "last step x0,max", "length"],
  ["lock", "critical friction μ_lock", "number"],
  ["f", "contact force f", "force"],
  ["alpha", "its inclination α", "angle"],
  ["phi1", "slope at the contact φ1", "angle"],
  ["sc", "contact at s_c", "length"],
  ["fx", "load on the clamp Fx", "force"],
  ["fy", "load on the clamp Fy", "force"],
  ["m", "moment on the clamp M", "moment"],
  ["energy", "bending energy", "energy"],
];

export class Explorer {
  /** @param {HTMLElement} root */
  constructor(root) {
    this.root = root;
    this.model = new Model();
    /** @type {import("./recording.js").Recording | null} */
    this.recording = null;
    /** @type {Division[]} */
    this.map = [];
    this.mapKey = "";
    /** @type {Preset[]} */
    this.presets = JSON.parse(this.at("presets").textContent || "[]");
    this.stage = new Stage(/** @type {SVGSVGElement} */ (this.graphic("stage")));
    this.plots = [
      new StickingPlot(this.graphic("sticking")),
      new SignalPlot(this.graphic("fx"), "fx", false),
      new SignalPlot(this.graphic("fy"), "fy", false),
      new SignalPlot(this.graphic("m"), "m", true),
      new RegimePlot(this.graphic("regimes")),
      new EnergyPlot(this.graphic("energy")),
    ];
    const places = {
      fields: this.at("fields"),
      choices: this.at("choices"),
      mounting: this.at("mounting"),
      rod: this.at("rod"),
    };
    this.controls = new Controls(places, (change) => this.change(change));
    this.outputs = this.readouts();
    /** @type {import("../solver/path.js").Path | undefined} */
    this.firstOf = undefined;
    this.playing = false;
    this.stopAt = Infinity;
    this.due = 0;
    this.clampAim = NaN;
    /** @type {Partial<Settings> | null} */
    this.waiting = null;
    this.dirty = true;
    this.spokenAt = 0;
    /** @type {string[]} */
    this.unspoken = [];
    this.listen();
    // A study's own scans come first where it has any.
    if (this.presets[0]?.recording) this.take({ ...this.presets[0], play: false });
    this.readAddress();
    this.resized();
    root.hidden = false;
    new ResizeObserver(() => this.resized()).observe(root);
    requestAnimationFrame((now) => this.frame(now));
  }

  /**
   * @param {string} name
   * @returns {HTMLElement}
   */
  at(name) {
    return /** @type {HTMLElement} */ (this.root.querySelector(`[data-x="${name}"]`));
  }

  /**
   * @param {string} name
   * @returns {SVGSVGElement}
   */
  graphic(name) {
    return /** @type {SVGSVGElement} */ (this.root.querySelector(`svg[data-x="${name}"]`));
  }

  /** @returns {Map<string, { value: HTMLElement, unit: HTMLElement, quantity: Quantity }>} */
  readouts() {
    const outputs = new Map();
    for (const [key, name, quantity] of READOUTS) {
      const [value, unit] = [element("output", { "data-value": key }), element("small", {})];
      const pair = element("div", {}, element("dt", {}, name), element("dd", {}, value, " ", unit));
      this.at("readouts").append(pair);
      outputs.set(key, { value, unit, quantity });
    }
    return outputs;
  }

  listen() {
    listenToClamp(this);
    listenToMap(this);
    listenToFiles(this);
    this.at("play").addEventListener("click", () => this.play(!this.playing));
    this.at("step").addEventListener("click", () => this.told(this.model.step()));
    this.at("restart").addEventListener("click", () => {
      this.play(false);
      this.model.restart();
      this.stage.left = -0.4;
      this.stopAt = Infinity;
      this.dirty = true;
    });
    const choice = /** @type {HTMLSelectElement} */ (this.at("preset"));
    this.presets.forEach((preset, i) => choice.append(element("option", { value: String(i) }, preset.name)));
    if (this.presets[0]?.recording) choice.value = "0";
    choice.addEventListener("change", () => {
      if (choice.value !== "") this.take(this.presets[Number(choice.value)]);
    });
    addEventListener("hashchange", () => this.readAddress());
  }

  /** What was read at the clamp, as the commands write it. */
  readings() {
    const { scale, name } = this.units;
    /** @param {Quantity} quantity */
    const unit = (quantity) =>
      this.units === NONDIMENSIONAL ? "" : ` [${name[quantity].replace("·", "*").replace("µ", "u")}]`;
    return asCsv(
      this.model.trace.map((row) => ({
        [`footpoint${unit("length")}`]: scale.length * row.clamp,
        [`force_x${unit("force")}`]: scale.force * row.fx,
        [`force_y${unit("force")}`]: scale.force * row.fy,
        [`moment_z${unit("moment")}`]: scale.moment * row.m,
        [`contact${unit("length")}`]: scale.length * row.contact,
        [`x0${unit("length")}`]: scale.length * row.x0,
        phi1: row.phi1,
        s_c: row.sc,
      })),
    );
  }

  get clampPlace() {
    return this.model.place ? this.model.place.clamp : 0;
  }

  get units() {
    const { units, modulus, diameter, length } = this.model.settings;
    return units === "si" ? unitsOf({ modulus, diameter, length }) : NONDIMENSIONAL;
  }

  /** @param {number} clamp */
  moveTo(clamp) {
    this.clampAim = Math.max(-5, Math.min(50, clamp));
  }

  /** @param {Partial<Settings>} change */
  change(change) {
    this.waiting = { ...this.waiting, ...change };
  }

  /** @param {boolean} on */
  play(on) {
    this.playing = on;
    this.due = 0;
    this.at("play").textContent = on ? "Pause" : "Play";
  }

  /** @param {Preset} preset */
  take(preset) {
    this.play(false);
    this.told(this.model.change(preset.settings));
    this.model.restart();
    this.stage.left = -0.4;
    this.told(this.model.moveTo(preset.clamp));
    this.recording = preset.recording;
    this.say(preset.note);
    this.stopAt = preset.recording ? Math.max(...preset.recording.clamp) : Infinity;
    this.play(preset.play);
    this.dirty = true;
  }

  readAddress() {
    const found = fromAddress(location.hash);
    if (!found || location.hash.slice(1) === this.written) return;
    this.model.change(found.settings);
    this.model.restart();
    this.told(this.model.moveTo(found.clamp));
    if (found.mistakes.length) this.say(`${found.mistakes.join("; ")}.`);
    this.dirty = true;
  }

  writeAddress() {
    clearTimeout(this.writing);
    this.writing = setTimeout(() => {
      this.written = toAddress(this.model.settings, this.clampPlace);
      // Another part of the page may be what the address points to.
      const mine = location.hash === "" || fromAddress(location.hash);
      if (mine) history.replaceState(null, "", `#${this.written}`);
    }, ADDRESS_AFTER);
  }

  resized() {
    this.stage.resize();
    for (const { plot } of this.plots) plot.resize();
    this.dirty = true;
  }

  /** @param {Event[]} events */
  told(events) {
    this.dirty = true;
    const { sticking } = this.model;
    if (!sticking) return;
    this.slid = events.some(({ what }) => what === "slips") ? performance.now() : (this.slid ?? -1e9);
    const texts = events.map((event) => told(event, sticking, (x) => this.length(x)));
    // Where a stretch of the model ends, nothing that follows is as important.
    const ended = events.findLastIndex(({ what }) => ENDS.includes(what));
    this.unspoken.push(...(ended < 0 ? texts : [texts[ended]]));
  }

  /** @param {number} value */
  length(value) {
    const { scale, name } = this.units;
    return `${significant(scale.length * withoutNoise(value))} ${name.length}`;
  }

  /** @param {string} text */
  say(text) {
    this.unspoken = [text];
    this.spokenAt = -Infinity;
  }

  /** @param {number} now */
  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    const start = performance.now();
    if (this.waiting) {
      this.told(this.model.change(this.waiting));
      if (MOUNTING_NUMBERS.some(({ key }) => key in (this.waiting ?? {}))) {
        this.unspoken.push(`Mounting: ${mounted(this.model.settings)}.`);
      }
      this.waiting = null;
    }
    if (!Number.isNaN(this.clampAim)) {
      this.told(this.model.moveTo(this.clampAim));
      this.clampAim = NaN;
    }
    if (this.playing) this.advance(now);
    const solved = performance.now() - start;
    if (this.dirty) {
      this.dirty = false;
      this.show(solved);
      this.writeAddress();
    } else if (this.mapOn(start)) this.dirty = true;
    if (this.unspoken.length && now - this.spokenAt > PATIENCE) {
      this.at("event").textContent = this.unspoken[this.unspoken.length - 1];
      this.unspoken = [];
      this.spokenAt = now;
    }
  }

  /** @param {number} now */
  advance(now) {
    const pace = matchMedia("(prefers-reduced-motion: reduce)").matches ? SLOW_PACE : PACE;
    if (now < this.due) return;
    this.due = Math.max(this.due + pace, now - pace);
    this.told(this.model.step());
    if (this.clampPlace >= this.stopAt - 1e-9) this.play(false);
  }

  /**
   * Go on with the map of regimes while there is time.
   *
   * @param {number} start
   * @returns {boolean} Whether there is more to be seen.
   */
  mapOn(start) {
    const { theta, eta, contact, section } = this.model.settings;
    const tapers = theta > 8 ? MORE_TAPERS : TAPERS;
    const mounting = mountingOf(this.model.settings);
    const key = [eta, contact, section, tapers.length, JSON.stringify(mounting)].join();
    if (key !== this.mapKey) {
      this.mapKey = key;
      this.map = [];
      this.solving = divisions({ eta, contact, round: section === "round", mounting }, tapers);
    }
    let found = false;
    while (this.solving && performance.now() - start < BUDGET) {
      const { value, done } = this.solving.next();
      if (done || !value) this.solving = undefined;
      else this.map.push(value);
      found = true;
    }
    return found;
  }

  /** @param {number} solved Milliseconds that the rod took. */
  show(solved) {
    const { model } = this;
    const { settings, sticking, state, place, now: reading, curve } = model;
    this.controls.show(settings);
    this.root.classList.toggle("si", settings.units === "si");
    this.root.classList.toggle("ratio", settings.law !== "free" && settings.delta === 0);
    this.root.classList.toggle("oblique", settings.delta !== 0);
    write(this.at("mounted"), mounted(settings));
    const failed = !sticking || !state || !place || !reading || !curve;
    this.root.classList.toggle("failed", failed || model.message !== "");
    const wrong = failed || model.message !== "";
    if (wrong) write(this.at("state"), `Not solved: ${model.message}.`);
    if (failed) return;
    const x0 = model.x0;
    const said = condition(sticking, place, state, x0);
    if (!wrong) write(this.at("state"), said);
    this.showStage(said);
    const { units, recording, map } = this;
    const view = { settings, units, sticking, curve, x0, now: reading, trace: model.trace, recording, divisions: map };
    for (const plot of this.plots) plot.show(view);
    this.showValues();
    const { rod } = sticking.path.branch;
    this.root.dataset.solved = String(solved);
    const now = performance.now();
    if (solved < 0.05 || now - (this.toldSolved ?? -Infinity) < PATIENCE) return;
    this.toldSolved = now;
    write(this.at("solved"), `Solved in ${spelled(solved, 1)} ms on ${rod.nodes} nodes`);
  }

  /** @param {string} said */
  showStage(said) {
    const { settings, sticking, state, place, now } = this.model;
    if (!sticking || !state || !place || !now) return;
    const { rod, force: unit } = sticking.path.branch;
    const shape = rod.shape(state, POINTS);
    if (this.firstOf !== sticking.path) {
      this.firstOf = sticking.path;
      this.first = rod.shape(sticking.path.pushed.knots[0].state, POINTS);
    }
    const { beta, delta } = settings;
    const stage = (delta * Math.PI) / 180;
    const start = place.clamp - place.side * this.model.x0;
    this.stage.show({
      theta: settings.theta,
      eta: settings.eta,
      mu0: settings.mu0,
      length: this.units.scale.length,
      clamp: place.clamp * Math.cos(stage),
      rise: place.clamp * Math.sin(stage),
      lean: place.side * beta,
      contact: place.contact - place.side * (1 - state.sc),
      side: place.side,
      ...shape,
      fx: state.fx,
      fy: state.fy,
      unit,
      slides: performance.now() - (this.slid ?? -1e9) < 250,
      ghost: {
        ...(this.first ?? shape),
        clamp: start * Math.cos(stage),
        rise: start * Math.sin(stage),
        side: place.side,
      },
    });
    const text = `${this.length(place.clamp)}, ${said}`;
    set(this.stage.clamp, { "aria-valuenow": place.clamp.toFixed(4), "aria-valuetext": text });
  }

  showValues() {
    const { settings, sticking, state, place, now } = this.model;
    if (!sticking || !state || !place || !now) return;
    const slips = sticking.highBy === "slips";
    /** @type {Record<string, number>} */
    const values = {
      clamp: place.clamp,
      x0: this.model.x0,
      slip: slips ? sticking.high : NaN,
      step: slips ? lastStep(sticking.high, settings.dx0) : NaN,
      lock: sticking.path.muLock,
      f: force(state),
      alpha: now.side * inclination(state),
      phi1: now.phi1,
      sc: state.sc,
      fx: now.fx,
      fy: now.fy,
      m: now.m,
      energy: now.energy,
    };
    const { scale, name } = this.units;
    for (const [key, { value, unit, quantity }] of this.outputs) {
      write(value, significant(scale[quantity] * withoutNoise(values[key])));
      write(unit, name[quantity]);
    }
    for (const [key, quantity] of /** @type {[string, Quantity][]} */ ([
      ["sticking", "length"], ["fx", "force"], ["fy", "force"], ["m", "moment"], ["energy", "energy"],
    ])) {
      write(this.at(`${key}-unit`), name[quantity]);
    }
  }
}

for (const root of document.querySelectorAll(".explorer")) {
  new Explorer(/** @type {HTMLElement} */ (root));
}
