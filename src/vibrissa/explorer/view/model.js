// The rod that the page moves: settings, solved path, place of clamp and tip, and what was read.

import { begun, isOblique, moved, placed, stickingOf, x0Of } from "../solver/motion.js";
import { sampled, solvedPath, stateAt } from "../solver/path.js";
import { demand } from "../solver/rod/state.js";
import { DEFAULTS, mountingOf } from "./settings.js";

/** @import { Event, Friction, Place, Sticking } from "../solver/motion.js" */
/** @import { State } from "../solver/rod/state.js" */
/** @import { Curve } from "../solver/path.js" */
/** @import { Reading } from "./panels.js" */
/** @import { Settings } from "./settings.js" */

/** Longest trace, and the parts of a move that are read one by one. */
const MOST_READINGS = 1500;
const MOST_PARTS = 16;
const PARTS_OF_A_STEP = 4;
const OF_THE_PATH = /** @type {const} */ ([
  "theta", "eta", "contact", "section", "beta", "compliance", "kappa0", "kappa1", "delta",
]);
/** Nearest and furthest height at which a period on an oblique stage is solved. */
const HEIGHTS = { low: 0.05, high: 0.998 };
const OF_FRICTION = /** @type {const} */ (["mu0", "ratio", "law"]);

/**
 * @typedef {Reading & { x0: number, contact: number, phi1: number, sc: number, side: number }} Row
 */

export class Model {
  constructor() {
    /** @type {Settings} */
    this.settings = { ...DEFAULTS };
    /** @type {Row[]} */
    this.trace = [];
    /** @type {Sticking | null} */
    this.sticking = null;
    /** @type {Place | undefined} */
    this.place = undefined;
    this.message = "";
    this.nodes = 0;
    this.solve(0);
  }

  /**
   * Change settings; the rod is solved anew where it is another one.
   *
   * @param {Partial<Settings>} change
   * @returns {Event[]} What happens because of it.
   */
  change(change) {
    const before = this.settings;
    this.settings = { ...before, ...change };
    if (OF_THE_PATH.some((key) => this.settings[key] !== before[key]) || !this.sticking) {
      this.solve(this.x0);
      return [];
    }
    if (!OF_FRICTION.some((key) => this.settings[key] !== before[key])) return [];
    this.sticking = stickingOf(this.sticking.path, this.friction);
    return this.place ? this.moveTo(this.place.clamp) : [];
  }

  /** @returns {Friction} On an oblique stage slips end at α = 0. */
  get friction() {
    const { mu0, ratio, law, delta } = this.settings;
    return { mu0, ratio, law: delta === 0 ? law : "free" };
  }

  /**
   * Solve the path of the rod, and put the clamp where it was relative to the tip.
   *
   * @param {number} x0
   */
  solve(x0) {
    const { clamp, side } = this.place ?? { clamp: 0, side: 1 };
    this.curve = null;
    this.begin(clamp - x0);
    if (!this.sticking) return;
    const { low, high } = this.sticking;
    const within = Math.min(high, Math.max(low, x0));
    this.place = placed(this.sticking, clamp, within, isOblique(this.sticking.path) ? 1 : side);
    this.trace = [];
    this.look();
  }

  /**
   * Solve the path of a period that begins with the clamp at a position of its stage.
   *
   * @param {number} clamp
   */
  begin(clamp) {
    const { theta, eta, contact, section } = this.settings;
    const mounting = mountingOf(this.settings);
    const height = eta - clamp * Math.sin(mounting.stage);
    const known = height > HEIGHTS.low && height < HEIGHTS.high;
    const rod = { theta, eta: height, contact, round: section === "round", mounting };
    const { path, message } = known
      ? solvedPath(rod, this.nodes)
      : { path: null, message: "the stage has left the heights at which a period can begin" };
    this.message = message;
    this.nodes = path ? path.branch.rod.nodes : 0;
    // Not more nodes for ever because of one rod that needed them.
    if (this.nodes > 30) this.nodes = Math.round(0.7 * this.nodes);
    this.sticking = path && stickingOf(path, this.friction);
    /** @type {Curve | null} */
    this.curve = path && sampled(path, PARTS_OF_A_STEP);
  }

  /** Displacement since α = 0. */
  get x0() {
    return this.sticking && this.place ? x0Of(this.sticking, this.place) : 0;
  }

  /** Begin anew with the clamp at 0. */
  restart() {
    if (this.settings.delta !== 0 || !this.sticking) this.begin(0);
    if (!this.sticking) return;
    this.place = begun(this.sticking);
    this.trace = [];
    this.look();
  }

  /**
   * Move the clamp without a stop.
   *
   * @param {number} clamp
   * @returns {Event[]}
   */
  moveTo(clamp) {
    if (!this.sticking || !this.place) return [];
    const from = this.place.clamp;
    const parts = Math.ceil(Math.abs(clamp - from) / this.settings.dx0);
    const count = Math.min(MOST_PARTS, Math.max(1, parts));
    /** @type {Event[]} */
    const events = [];
    for (let k = 1; k <= count; k += 1) {
      events.push(...this.part(from + ((clamp - from) * k) / count, false));
    }
    return events;
  }

  /**
   * Move the clamp by one step, after which a tip slips that has been moved too far.
   *
   * @returns {Event[]}
   */
  step() {
    if (!this.sticking || !this.place) return [];
    // Multiples of the step, not sums of it.
    const number = Math.round(this.place.clamp / this.settings.dx0) + 1;
    return this.part(number * this.settings.dx0, true);
  }

  /**
   * @param {number} clamp
   * @param {boolean} stepped
   * @returns {Event[]}
   */
  part(clamp, stepped) {
    if (!this.sticking || !this.place) return [];
    const { place, events } = moved(this.sticking, this.place, clamp, stepped);
    const jump = events.find(({ what }) => what === "slips" || what === "swings");
    if (jump && !stepped) {
      // The last reading before the jump, and the first after it.
      this.place = placed(this.sticking, jump.clamp, jump.x0, this.place.side);
      this.look();
      this.place = placed(this.sticking, jump.clamp, jump.rest, jump.side);
      this.look();
    }
    this.place = place;
    const last = events[events.length - 1];
    const ended = last && isOblique(this.sticking.path) && last.rest === 0 && last.x0 !== 0;
    if (!ended) {
      this.look();
      return events;
    }
    // Another height: the next period has a path of its own.
    this.begin(place.clamp);
    if (!this.sticking) return events;
    this.place = placed(this.sticking, place.clamp, 0, 1);
    this.look();
    const more = place.clamp === clamp ? [] : this.part(clamp, stepped);
    return [...events, ...more];
  }

  /** Solve the state in which the rod is now, and read the clamp's forces. */
  look() {
    if (!this.sticking || !this.place) return;
    const { sticking, place } = this;
    const { branch } = sticking.path;
    const x0 = x0Of(sticking, place);
    const state = stateAt(sticking.path, Math.max(sticking.low, Math.min(sticking.high, x0)));
    if (!state) {
      this.message = `no state was found at x0 = ${x0.toFixed(4)}`;
      return;
    }
    this.message = "";
    this.state = state;
    const { fx, fy, m, phi1, sc } = state;
    const { side } = place;
    const row = { clamp: place.clamp, x0, contact: place.contact, fx: side * fx, fy, m: side * m };
    const last = this.trace[this.trace.length - 1];
    if (last && last.clamp === row.clamp && last.x0 === x0) this.trace.pop();
    this.trace.push({ ...row, phi1: side > 0 ? phi1 : Math.PI - phi1, sc, side });
    if (this.trace.length > MOST_READINGS) this.trace.splice(0, MOST_READINGS / 3);
    this.now = {
      ...this.trace[this.trace.length - 1],
      demand: demand(state),
      energy: branch.rod.energyOf(state.unknowns),
    };
  }
}
