// The page: a user's actions move the model, and each frame shows its state.

import { isMirrored, isOblique } from "../solver/motion.js";
import { RegimeMap } from "../solver/regimes.js";
import { Controls, element } from "./controls.js";
import { listenToClamp, listenToCurve, listenToFiles, listenToMap } from "./hands.js";
import { Introduction, showHelp } from "./help.js";
import { misfitOf } from "./misfit.js";
import { Model, pinsOf } from "./model.js";
import { EnergyPlot, RegimePlot, SignalPlot, StickingPlot, WavePlot } from "./panels.js";
import { Readouts } from "./readouts.js";
import { CLAMP_RANGE, DEFAULTS, fromAddress, lawOf, MOST_PINS, MOUNTING_NUMBERS, toAddress, WAVE_NUMBERS } from "./settings.js";
import { Stage } from "./stage.js";
import { set, significant, withoutNoise, write } from "./svg.js";
import { NONDIMENSIONAL, unitsOf } from "./units.js";
import { condition, mounted, parameters, rodName, surfaced, told } from "./words.js";

/** Arc lengths of the points of the drawn rod. */
const POINTS = Float64Array.from({ length: 81 }, (_, i) => i / 80);
/** Milliseconds that the map of regimes may take of a frame, and between two changes of the message. */
const BUDGET = 5;
const PATIENCE = 350;
/** Milliseconds after which the message about an event fades. */
const FADES = 8000;
/** Milliseconds in which the plane of the rod turns, or the rod snaps. */
const TURN = 500;
/** Milliseconds between two comparisons with a recording. */
const COMPARED = 300;
/** Milliseconds after which the page's address is updated. */
const ADDRESS_AFTER = 300;
/** Speeds of Play: milliseconds between moves of the clamp, steps in a move, and milliseconds of a slip. */
const PACES = {
  slow: { pause: 80, steps: 1, slip: 1500 },
  normal: { pause: 1000 / 60, steps: 1, slip: 300 },
  fast: { pause: 1000 / 60, steps: 5, slip: 60 },
};
/** The same for users who prefer reduced motion. */
const CALM = { pause: 250, steps: 1, slip: 0 };
/** Motion of the clamp during a slip that ends its animation, as a part of the slip. */
const HURRY = 0.5;

/** Events in which the tip or the plane of the rod jumps. @type {Incident["what"][]} */
const JUMPS = ["slips", "swings", "snaps"];
/** What the rod does meanwhile. @type {Partial<Record<Incident["what"], string>>} */
const MOTIONS = { slips: "slips", swings: "buckles laterally", snaps: "snaps through" };

/** @type {Incident["what"][]} */
const ENDS = ["swings", "snaps", "slips back", "flies off", "is lost", "lifts", "inadmissible", "lost"];

export class Explorer {
  /** @param {HTMLElement} root */
  constructor(root) {
    this.root = root;
    this.model = new Model();
    /** @type {(whisker: Whisker) => Recording | null} */
    this.recorded = () => null;
    /** @type {Pin[]} */
    this.pins = [];
    this.map = new RegimeMap();
    /** @type {Preset[]} */
    this.presets = JSON.parse(this.at("presets").textContent || "[]");
    this.stage = new Stage(this.graphic("stage"));
    this.plots = [
      new StickingPlot(this.graphic("sticking")),
      new SignalPlot(this.graphic("fx"), "fx", false),
      new SignalPlot(this.graphic("fy"), "fy", false),
      new SignalPlot(this.graphic("m"), "m", true),
      new RegimePlot(this.graphic("regimes")),
      new EnergyPlot(this.graphic("energy")),
      new WavePlot(this.graphic("wave"), this.at("waves")),
    ];
    const [fields, choices, mounting, wave, rod] = ["fields", "choices", "mounting", "wave-fields", "rod"].map((name) => {
      return this.at(name);
    });
    this.controls = new Controls({ fields, choices, mounting, wave, rod }, (change) => {
      this.introduction.did("controls");
      this.change(change);
    });
    this.readouts = new Readouts(this.at("readouts"), this.at("more"));
    this.playing = false;
    this.stopAt = Infinity;
    this.due = 0;
    this.clampAim = NaN;
    /** The jump that is animated. @type {{ event: Incident, since: number, lasts: number } | null} */
    this.slide = null;
    /** @type {Omit<Jump, "part"> | null} */
    this.jump = null;
    this.byHand = false;
    this.fadeAt = Infinity;
    this.fades = false;
    this.comparedAt = -Infinity;
    this.uncompared = false;
    /** @type {Partial<Settings> | null} */
    this.waiting = null;
    /** Whether the wave is on the page. */
    this.wavy = false;
    this.dirty = true;
    this.spokenAt = -Infinity;
    /** @type {string | null} */
    this.unspoken = null;
    this.choice = /** @type {HTMLSelectElement} */ (this.at("preset"));
    this.introduction = new Introduction(this);
    this.listen();
    this.reset();
    this.readAddress();
    root.hidden = false;
    new ResizeObserver(() => this.resized()).observe(root);
    requestAnimationFrame((now) => this.frame(now));
  }

  /** @type {(name: string) => HTMLElement} */
  at(name) {
    return /** @type {HTMLElement} */ (this.root.querySelector(`[data-x="${name}"]`));
  }

  /** @type {(name: string) => SVGSVGElement} */
  graphic(name) {
    return /** @type {SVGSVGElement} */ (this.root.querySelector(`svg[data-x="${name}"]`));
  }

  listen() {
    listenToClamp(this);
    listenToCurve(this);
    listenToMap(this);
    listenToFiles(this);
    showHelp(this.root);
    /** @type {Record<string, () => void>} */
    const buttons = {
      play: () => this.play(!this.playing),
      step: () => this.told(this.model.step()),
      restart: () => this.restart(),
      reset: () => this.reset(),
      link: () => this.copyLink(),
      pin: () => this.pin(),
      unpin: () => {
        this.pins = [];
        this.dirty = true;
      },
      introduce: () => this.introduction.show(0),
    };
    for (const [name, act] of Object.entries(buttons)) this.at(name).addEventListener("click", act);
    const menu = /** @type {HTMLDetailsElement} */ (this.at("menu"));
    menu.addEventListener("click", ({ target }) => {
      if (/** @type {Element} */ (target).matches("button, input")) menu.open = false;
    });
    this.presets.forEach((preset, i) => {
      this.choice.append(element("option", { value: String(i) }, preset.name));
    });
    this.choice.addEventListener("change", () => {
      if (this.choice.value !== "") this.take(this.presets[Number(this.choice.value)]);
    });
    addEventListener("hashchange", () => this.readAddress());
    // No introduction for users who follow a link or read a report.
    if (this.root.closest(".alone") && location.hash === "") this.introduction.show(0);
  }

  get clampPlace() {
    return this.model.place.clamp;
  }

  get units() {
    return this.model.settings.units === "si" ? unitsOf(this.model.settings) : NONDIMENSIONAL;
  }

  get pace() {
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    return calm ? CALM : PACES[this.model.settings.speed];
  }

  /** @type {(clamp: number) => void} */
  moveTo(clamp) {
    this.play(false);
    this.byHand = true;
    this.clampAim = Math.max(CLAMP_RANGE.min, Math.min(CLAMP_RANGE.max, clamp));
  }

  /** Move the clamp by steps from its position, or from its target if it moves. @type {(steps: number) => void} */
  moveBy(steps) {
    const from = Number.isNaN(this.clampAim) ? this.clampPlace : this.clampAim;
    this.moveTo(from + steps * this.model.settings.dx0);
  }

  /** Move the clamp to a displacement at which the tip sticks. @type {(x0: number) => void} */
  stickAt(x0) {
    const { sticking, place } = this.model;
    if (!sticking) return;
    this.introduction.did("curve");
    const within = Math.min(sticking.high, Math.max(sticking.low, x0));
    this.moveTo(place.clamp + place.side * (within - place.x0));
  }

  /** Apply a user's settings in the next frame. @type {(change: Partial<Settings>) => void} */
  change(change) {
    this.waiting = { ...this.waiting, ...change };
    if (Object.keys(change).every((key) => key === "labels" || key === "speed")) return;
    // The message and the preset's name belong to the previous settings.
    this.say("");
    this.jump = null;
    this.choice.value = "";
  }

  /** @type {(on: boolean) => void} */
  play(on) {
    // Beyond the end of a study's recording, Play goes on.
    if (on && this.clampPlace >= this.stopAt) this.stopAt = Infinity;
    this.playing = on;
    this.due = 0;
    write(this.at("play"), on ? "Pause" : "Play");
  }

  /** Put the clamp at 0, with α = 0. */
  restart() {
    this.play(false);
    this.slide = null;
    this.jump = null;
    this.clampAim = NaN;
    this.model.restore(0, 0, 1);
    this.stopAt = Infinity;
    this.say("");
    this.dirty = true;
  }

  /** Restore the page as it was when it was opened. */
  reset() {
    const [first] = this.presets;
    this.pins = [];
    // If a study has scans, the first of them is shown.
    if (first?.recording) this.take({ ...first, settings: { ...DEFAULTS, ...first.settings }, play: false });
    else this.take({ name: "", note: "", settings: DEFAULTS, clamp: 0, play: false, recording: null });
    this.choice.value = first?.recording ? "0" : "";
    this.controls.show(this.model.settings, true);
  }

  /** @param {Preset} preset */
  take(preset) {
    this.waiting = null;
    this.told(this.model.change(preset.settings));
    this.restart();
    this.told(this.model.moveTo(preset.clamp));
    this.slide = null;
    this.jump = null;
    this.recorded = () => preset.recording;
    this.say(preset.note);
    this.stopAt = preset.recording ? Math.max(...preset.recording.clamp) : Infinity;
    this.controls.show(this.model.settings, true);
    this.play(preset.play);
  }

  /** Keep the curve of this rod beside those of others. */
  pin() {
    const { settings } = this.model;
    const made = pinsOf([settings]);
    this.pins = [...this.pins, ...made].slice(-MOST_PINS);
    this.introduction.did("controls");
    this.say(made.length ? `Pinned: ${rodName(settings)}. Change the rod to compare.` : "There is no curve to pin.");
    this.dirty = true;
  }

  readAddress() {
    const found = fromAddress(location.hash);
    if (!found || location.hash.slice(1) === this.written) return;
    const { settings, clamp, x0, tip, side, pins, mistakes } = found;
    const { recorded } = this;
    this.take({ name: "", note: "", settings, clamp: 0, play: false, recording: null });
    this.recorded = recorded;
    this.choice.value = "";
    const moves = Number.isNaN(settings.amplitude === 0 ? x0 : tip);
    this.model.restore(moves ? 0 : clamp, moves || Number.isNaN(x0) ? 0 : x0, side, moves ? NaN : tip);
    if (moves) this.told(this.model.moveTo(clamp));
    this.slide = null;
    this.pins = pinsOf(pins);
    if (mistakes.length) this.say(`${mistakes.join("; ")}.`);
  }

  get address() {
    const { settings, place, contact } = this.model;
    return toAddress({ settings, ...place, tip: contact, pins: this.pins.map((pin) => pin.settings) });
  }

  writeAddress() {
    clearTimeout(this.writing);
    this.writing = setTimeout(() => {
      this.written = this.address;
      // The address may point to another part of the page.
      const mine = location.hash === "" || fromAddress(location.hash);
      if (mine) history.replaceState(null, "", `#${this.written}`);
    }, ADDRESS_AFTER);
  }

  async copyLink() {
    const link = `${location.href.split("#")[0]}#${this.address}`;
    try {
      await navigator.clipboard.writeText(link);
      this.say("Link copied: it brings back all settings, the clamp and the pinned curves.");
    } catch {
      this.say("The browser does not allow copying: the address bar holds the same link.");
    }
  }

  /** Parameters and state, as the title of an export. */
  summary() {
    const place = `clamp at ${this.length(this.clampPlace)}, x0 = ${this.length(this.model.place.x0)}`;
    const pins = this.pins.map(({ settings }) => `; pinned: ${rodName(settings)}`);
    return `Vibrissa: ${parameters(this.model.settings)}; ${place}${pins.join("")}`;
  }

  resized() {
    this.stage.resize();
    for (const { plot } of this.plots) plot.resize();
    this.dirty = true;
  }

  /** Prepare the message for events, and animate a jump. @type {(events: Incident[]) => void} */
  told(events) {
    this.dirty = true;
    const { sticking } = this.model;
    if (!sticking || !events.length) return;
    const jumps = isOblique(sticking.path) ? [] : events.filter(({ what }) => JUMPS.includes(what));
    const last = jumps[jumps.length - 1];
    const { slip } = this.pace;
    const lasts = last?.what === "slips" || slip === 0 ? slip : TURN;
    this.slide = jumps.length === 1 && lasts ? { event: last, since: performance.now(), lasts } : null;
    this.jump = last ? this.jumpOf(last) : null;
    if (this.byHand) this.introduction.did("stage");
    // The event that ends the path is more important than those after it.
    const event = events.findLast(({ what }) => ENDS.includes(what)) ?? events[events.length - 1];
    this.unspoken = told(event, sticking, (x) => this.length(x));
    this.fades = true;
  }

  /** The rod before a jump, and the way of its contact point. @type {(event: Incident) => Omit<Jump, "part"> | null} */
  jumpOf(event) {
    const { what, clamp, x0, rest, side, slid } = event;
    const { model } = this;
    if (!model.sticking) return null;
    const { path } = model.sticking;
    const way = what === "swings" && isMirrored(path) ? -side : side;
    const before = slid ? model.readingIn(event, 0) : model.reading({ clamp, x0, side: way });
    const after = model.reading({ clamp, x0: rest, side });
    if (!before || !after) return null;
    const { x, y } = path.branch.rod.shape(before.state, POINTS);
    const line = { x: x.map((value) => clamp + way * value), y };
    const [from, to] = [before.contact, after.contact];
    return { before: line, from, to, text: this.length(Math.abs(to - from)) };
  }

  /** @type {(value: number) => string} */
  length(value) {
    const { scale, name } = this.units;
    return `${significant(scale.length * withoutNoise(value))} ${name.length}`;
  }

  /** @type {(text: string, fades?: boolean) => void} */
  say(text, fades = false) {
    this.unspoken = text;
    this.fades = fades;
    this.spokenAt = -Infinity;
  }

  /** @type {(now: number) => void} */
  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    const start = performance.now();
    this.moveOn(now);
    // While a user drags, the map waits.
    if ((this.playing || !this.dirty) && this.map.solve(this.model.rod, start + BUDGET)) this.dirty = true;
    if (this.dirty) {
      this.dirty = false;
      this.show();
      this.writeAddress();
    }
    if (this.unspoken !== null && now - this.spokenAt > PATIENCE) {
      write(this.at("event"), this.unspoken);
      this.unspoken = null;
      this.spokenAt = now;
      this.fadeAt = this.fades ? now + FADES : Infinity;
    }
    this.at("event").classList.toggle("past", now > this.fadeAt);
    if (this.uncompared && now - this.comparedAt > COMPARED) {
      this.uncompared = false;
      this.comparedAt = now;
      this.compare();
    }
  }

  /** Write how well the readings fit the recording that is shown. */
  compare() {
    const { settings, trace } = this.model;
    const recording = this.recorded(settings);
    this.at("recorded").hidden = !recording;
    if (!recording) return;
    write(this.at("record"), recording.name);
    write(this.at("misfit"), misfitOf(trace, recording));
  }

  /** Apply waiting changes and moves; the clamp waits while a slip is animated. @type {(now: number) => void} */
  moveOn(now) {
    if (this.waiting) {
      this.slide = null;
      this.told(this.model.change(this.waiting));
      if (MOUNTING_NUMBERS.some(({ key }) => key in (this.waiting ?? {}))) {
        this.unspoken = `Mounting: ${mounted(this.model.settings)}.`;
      }
      if (WAVE_NUMBERS.some(({ key }) => key in (this.waiting ?? {}))) {
        this.unspoken = `Surface: ${surfaced(this.model.settings)}.`;
      }
      this.waiting = null;
    }
    if (this.slide) {
      const { event, since, lasts } = this.slide;
      const hurried = Math.abs(this.clampAim - event.clamp) > HURRY * Math.abs(event.x0);
      if (hurried || performance.now() - since > lasts) this.slide = null;
      this.dirty = true;
      if (this.slide) return;
    }
    if (!Number.isNaN(this.clampAim)) {
      this.told(this.model.moveTo(this.clampAim));
      this.byHand = false;
      this.clampAim = NaN;
    }
    if (this.playing) this.advance(now);
  }

  /** @type {(now: number) => void} */
  advance(now) {
    const { pause, steps } = this.pace;
    if (now < this.due) return;
    this.due = Math.max(this.due + pause, now - pause);
    for (let k = 0; k < steps && this.playing && !this.slide; k += 1) {
      this.told(this.model.step());
      if (this.clampPlace >= Math.min(this.stopAt, CLAMP_RANGE.max) - 1e-9) this.play(false);
    }
  }

  /** Part of the animated jump that is done, from 0 to 1. */
  get done() {
    if (!this.slide) return 1;
    const part = Math.min(1, (performance.now() - this.slide.since) / this.slide.lasts);
    return part * part * (3 - 2 * part);
  }

  /** The reading that is shown: during a slip, of a state on the way. @type {(done: number) => Reading | undefined} */
  shown(done) {
    const { model, slide } = this;
    if (!slide || !model.sticking) return model.now;
    const { what, clamp, x0, rest, side, slid } = slide.event;
    if (slid) return model.readingIn(slide.event, done) ?? model.now;
    const at = what === "slips" ? x0 + (rest - x0) * done : rest;
    return model.reading({ clamp, x0: at, side }) ?? model.now;
  }

  show() {
    const { model, root } = this;
    const { settings, sticking, curve, message } = model;
    const { done } = this;
    const now = this.shown(done);
    this.controls.show(settings);
    root.classList.toggle("si", settings.units === "si");
    root.classList.toggle("ratio", lawOf(settings) !== "free");
    root.classList.toggle("oblique", settings.delta !== 0);
    root.classList.toggle("line", settings.contact === "line");
    if (root.classList.toggle("wave", settings.amplitude !== 0) !== this.wavy) {
      this.wavy = !this.wavy;
      this.resized();
    }
    write(this.at("mounted"), mounted(settings));
    write(this.at("surfaced"), surfaced(settings));
    this.at("unpin").toggleAttribute("disabled", this.pins.length === 0);
    const failed = !sticking || !now || !curve;
    root.classList.toggle("failed", failed || message !== "");
    if (failed || message) write(this.at("state"), `Not solved: ${message}.`);
    if (failed) return this.play(false);
    const said = this.slide ? MOTIONS[this.slide.event.what] ?? "jumps" : condition(sticking, now);
    if (!message) write(this.at("state"), said);
    this.showStage(now, said, done);
    this.uncompared = true;
    const { units, pins } = this;
    const recording = this.recorded(settings);
    const { trace, rests, slipsInWave } = model;
    const { divisions } = this.map;
    const view = { settings, units, sticking, curve, now, trace, rests, slipsInWave, recording, divisions, pins };
    for (const part of [...this.plots, this.readouts]) part.show(view);
    for (const [key, quantity] of /** @type {[string, Quantity][]} */ ([
      ["sticking", "length"], ["fx", "force"], ["fy", "force"], ["m", "moment"], ["energy", "energy"],
    ])) {
      write(this.at(`${key}-unit`), units.name[quantity]);
    }
  }

  /** @type {(now: Reading, said: string, done: number) => void} */
  showStage(now, said, done) {
    const { settings, sticking } = this.model;
    if (!sticking) return;
    const { rod, force: unit } = sticking.path.branch;
    const shape = rod.shape(now.state, POINTS);
    const first = rod.shape(sticking.path.pushed.knots[0].state, POINTS);
    const { slide } = this;
    // A rod that buckles laterally turns about the line from its clamp to its tip, and stays as it is.
    const turns = slide?.event.what === "swings" && isMirrored(sticking.path);
    const facing = turns ? -now.side * Math.cos(Math.PI * done) : now.side;
    const part = slide && !turns && slide.event.what !== "slips" ? done : 1;
    const jump = this.jump && { ...this.jump, part };
    const length = this.units.scale.length;
    this.stage.show({ settings, now, shape, first, facing, jump, length, unit, slides: slide !== null });
    const text = `${this.length(now.clamp)}, ${said}`;
    set(this.stage.clamp, { "aria-valuenow": now.clamp.toFixed(4), "aria-valuetext": text });
  }
}

for (const root of document.querySelectorAll(".explorer")) {
  new Explorer(/** @type {HTMLElement} */ (root));
}
