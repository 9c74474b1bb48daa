// The rod on the page: settings, solved path, positions of clamp and tip, and readings.

import { isMirrored, isOblique, moved, placed, stickingOf, x0Of } from "../solver/motion.js";
import { sampled, solvedPath, stateAt } from "../solver/path.js";
import { demand } from "../solver/rod/state.js";
import { DEFAULTS, lawOf, mountingOf } from "./settings.js";

/** Most readings of a trace; most parts of a move, with a reading each; samples of each step of a path. */
const MOST_READINGS = 1500;
const MOST_PARTS = 16;
const PARTS_OF_A_STEP = 4;
/** Lowest and largest height at which a period on an oblique stage is solved. */
const HEIGHTS = { low: 0.05, high: 0.998 };

/** @type {(settings: Settings) => Required<Given>} */
export function rodOf(settings) {
  const { theta, eta, contact, section } = settings;
  return { theta, eta, contact, round: section === "round", mounting: mountingOf(settings) };
}

/** @type {(one: object, other: object) => boolean} */
function differ(one, other) {
  return JSON.stringify(one) !== JSON.stringify(other);
}

/** The curves of those rods that can be solved. @type {(rods: Settings[]) => Pin[]} */
export function pinsOf(rods) {
  return rods.flatMap((settings) => {
    const { path } = solvedPath(rodOf(settings));
    return path ? [{ settings, curve: sampled(path, PARTS_OF_A_STEP), muLock: path.muLock }] : [];
  });
}

export class Model {
  constructor() {
    /** @type {Settings} */
    this.settings = { ...DEFAULTS };
    /** @type {Reading[]} */
    this.trace = [];
    /** @type {Sticking | null} */
    this.sticking = null;
    /** @type {Place | undefined} */
    this.place = undefined;
    /** @type {Reading | undefined} */
    this.now = undefined;
    this.message = "";
    this.nodes = 0;
    this.solve(0);
  }

  /**
   * Change settings, and return the events that this causes; a changed rod is solved anew.
   * @type {(change: Partial<Settings>) => Incident[]}
   */
  change(change) {
    const { rod, friction } = this;
    this.settings = { ...this.settings, ...change };
    if (differ(rod, this.rod) || !this.sticking) {
      this.solve(this.x0);
      return [];
    }
    if (!differ(friction, this.friction)) return [];
    this.sticking = stickingOf(this.sticking.path, this.friction);
    // All readings of a trace have the same friction.
    this.trace = [];
    return this.place ? this.moveTo(this.place.clamp) : [];
  }

  get rod() {
    return rodOf(this.settings);
  }

  /** @returns {Friction} */
  get friction() {
    const { mu0, ratio } = this.settings;
    return { mu0, ratio, law: lawOf(this.settings) };
  }

  /** Solve the path of the rod, and put the clamp where it was. @type {(x0: number) => void} */
  solve(x0) {
    const { clamp, side } = this.place ?? { clamp: 0, side: 1 };
    this.curve = null;
    this.begin(clamp - x0);
    if (!this.sticking) return;
    const { low, high } = this.sticking;
    const within = Math.min(high, Math.max(low, x0));
    this.place = placed(this.sticking, clamp, within, isMirrored(this.sticking.path) ? side : 1);
    this.trace = [];
    this.look();
  }

  /** Solve the period that begins with the clamp at a position of its stage. @type {(clamp: number) => void} */
  begin(clamp) {
    const { rod } = this;
    const eta = rod.eta - clamp * Math.sin(rod.mounting.stage);
    const { path, message } = eta > HEIGHTS.low && eta < HEIGHTS.high
      ? solvedPath({ ...rod, eta }, this.nodes)
      : { path: null, message: "the stage has left the heights at which a period can begin" };
    this.message = message;
    this.nodes = path ? path.branch.rod.nodes : 0;
    // Reduce the number, so that later rods do not keep nodes that only one rod needed.
    if (this.nodes > 30) this.nodes = Math.round(0.7 * this.nodes);
    this.sticking = path && stickingOf(path, this.friction);
    /** @type {Curve | null} */
    this.curve = path && sampled(path, PARTS_OF_A_STEP);
  }

  /** Displacement since α = 0. */
  get x0() {
    return this.sticking && this.place ? x0Of(this.sticking, this.place) : 0;
  }

  /** Restore positions of clamp and tip. @type {(clamp: number, x0: number, side: number) => void} */
  restore(clamp, x0, side) {
    this.place = { clamp, contact: 0, side };
    this.solve(x0);
  }

  /** Move the clamp continuously. @type {(clamp: number) => Incident[]} */
  moveTo(clamp) {
    if (!this.sticking || !this.place) return [];
    const from = this.place.clamp;
    const parts = Math.ceil(Math.abs(clamp - from) / this.settings.dx0);
    const count = Math.min(MOST_PARTS, Math.max(1, parts));
    /** @type {Incident[]} */
    const events = [];
    for (let k = 1; k <= count; k += 1) {
      events.push(...this.part(from + ((clamp - from) * k) / count, false));
    }
    return events;
  }

  /** Move the clamp by one step; if it passes the onset, the tip slips after the step. @type {() => Incident[]} */
  step() {
    if (!this.sticking || !this.place) return [];
    // Multiples of the step, not sums of it.
    const number = Math.round(this.place.clamp / this.settings.dx0) + 1;
    return this.part(number * this.settings.dx0, true);
  }

  /** @type {(clamp: number, stepped: boolean) => Incident[]} */
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
    // The next period is at another height, and has another path.
    this.begin(place.clamp);
    if (!this.sticking) return events;
    this.place = placed(this.sticking, place.clamp, 0, 1);
    this.look();
    const more = place.clamp === clamp ? [] : this.part(clamp, stepped);
    return [...events, ...more];
  }

  /** Solve the present state of the rod, and add a reading to the trace. */
  look() {
    if (!this.place) return;
    const reading = this.reading(this.place);
    this.message = reading ? "" : `no state was found at x0 = ${this.x0.toFixed(4)}`;
    if (!reading) return;
    this.now = reading;
    const last = this.trace[this.trace.length - 1];
    if (last && last.clamp === reading.clamp && last.x0 === reading.x0) this.trace.pop();
    this.trace.push(reading);
    if (this.trace.length > MOST_READINGS) this.trace.splice(0, MOST_READINGS / 3);
  }

  /** State and loads at a place; null if no state is found. @type {(place: Place) => Reading | null} */
  reading(place) {
    if (!this.sticking) return null;
    const { path, low, high } = this.sticking;
    const x0 = x0Of(this.sticking, place);
    const state = stateAt(path, Math.max(low, Math.min(high, x0)));
    if (!state) return null;
    const { fx, fy, m, phi1, sc } = state;
    const { side } = place;
    return {
      ...place,
      x0,
      state,
      fx: side * fx,
      fy,
      m: side * m,
      phi1: side > 0 ? phi1 : Math.PI - phi1,
      sc,
      demand: demand(state),
      energy: path.branch.rod.energyOf(state.unknowns),
    };
  }
}
