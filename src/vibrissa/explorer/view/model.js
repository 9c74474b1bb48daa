// The rod on the page: settings, solved path, positions of clamp and tip, and readings.

import { isMirrored, isOblique, moved, stickingOf } from "../solver/motion.js";
import { sampled, solvedPath, stateAt } from "../solver/path.js";
import { demand } from "../solver/rod/state.js";
import { CLAMP_RANGE, DEFAULTS, lawOf, mountingOf } from "./settings.js";

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
    /** @type {Place} */
    this.place = { clamp: 0, x0: 0, side: 1 };
    /** @type {Reading | undefined} */
    this.now = undefined;
    this.message = "";
    this.nodes = 0;
    this.solve();
  }

  /**
   * Change settings, and return the events that this causes; a changed rod is solved anew.
   * @type {(change: Partial<Settings>) => Incident[]}
   */
  change(change) {
    const { rod, friction } = this;
    this.settings = { ...this.settings, ...change };
    if (differ(rod, this.rod) || !this.sticking) {
      this.solve();
      return [];
    }
    if (!differ(friction, this.friction)) return [];
    this.sticking = stickingOf(this.sticking.path, this.friction, this.place.x0);
    // The clamp rests, but friction may no longer hold the tip.
    const events = this.moveTo(this.place.clamp);
    // All readings of a trace have the same friction.
    this.trace = this.trace.slice(-1);
    return events;
  }

  get rod() {
    return rodOf(this.settings);
  }

  /** @returns {Friction} */
  get friction() {
    const { mu0, ratio } = this.settings;
    return { mu0, ratio, law: lawOf(this.settings) };
  }

  /** Solve the path of the rod, and put clamp and tip where they were. */
  solve() {
    const { clamp, x0, side } = this.place;
    this.trace = [];
    this.begin(clamp - x0, x0);
    if (!this.sticking) return;
    const { path, low, high } = this.sticking;
    this.place = { clamp, x0: Math.min(high, Math.max(low, x0)), side: isMirrored(path) ? side : 1 };
    this.look();
  }

  /** Solve the period that begins with the clamp at a position of its stage. @type {(clamp: number, x0?: number) => void} */
  begin(clamp, x0 = 0) {
    const { rod } = this;
    const eta = rod.eta - clamp * Math.sin(rod.mounting.stage);
    const { path, message } = eta > HEIGHTS.low && eta < HEIGHTS.high
      ? solvedPath({ ...rod, eta }, this.nodes)
      : { path: null, message: "the stage has left the heights at which a period can begin: move or reset the clamp" };
    this.message = message;
    this.nodes = path ? path.branch.rod.nodes : 0;
    // Reduce the number, so that later rods do not keep nodes that only one rod needed.
    if (this.nodes > 30) this.nodes = Math.round(0.7 * this.nodes);
    this.sticking = path && stickingOf(path, this.friction, x0);
    /** @type {Curve | null} */
    this.curve = path && sampled(path, PARTS_OF_A_STEP);
  }

  /** Restore positions of clamp and tip. @type {(clamp: number, x0: number, side: number) => void} */
  restore(clamp, x0, side) {
    this.place = { clamp, x0, side };
    this.solve();
  }

  /** Move the clamp continuously. @type {(clamp: number) => Incident[]} */
  moveTo(clamp) {
    const from = this.place.clamp;
    const parts = this.sticking ? Math.ceil(Math.abs(clamp - from) / this.settings.dx0) : 1;
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
    const { dx0 } = this.settings;
    // Multiples of the step, not sums of it.
    const number = Math.floor(this.place.clamp / dx0 + 1e-9) + 1;
    return this.part(Math.min(number * dx0, CLAMP_RANGE.max), true);
  }

  /** @type {(clamp: number, stepped: boolean) => Incident[]} */
  part(clamp, stepped) {
    if (!this.sticking) {
      // Without a solved period, one begins anew where the clamp is to be, if one can.
      this.begin(clamp);
      if (!this.sticking) return [];
      this.place = { clamp, x0: 0, side: 1 };
      this.look();
      return [];
    }
    const { place, events } = moved(this.sticking, this.place, clamp, stepped);
    const jump = events.find(({ what }) => what === "slips" || what === "swings");
    if (jump && !stepped) {
      // The last reading before the jump, and the first after it.
      this.place = { ...this.place, clamp: jump.clamp, x0: jump.x0 };
      this.look();
      this.place = { clamp: jump.clamp, x0: jump.rest, side: jump.side };
      this.look();
    }
    this.place = place;
    const last = events[events.length - 1];
    if (last && isOblique(this.sticking.path) && last.rest === 0 && last.x0 !== 0) {
      // The next period is at another height, and has another path.
      this.begin(place.clamp);
      if (!this.sticking) return events;
    } else if (place.x0 < this.sticking.low) {
      // The tip has left the places past the critical state.
      this.sticking = stickingOf(this.sticking.path, this.friction);
    }
    this.look();
    return place.clamp === clamp ? events : [...events, ...this.part(clamp, stepped)];
  }

  /** Solve the present state of the rod, and add a reading to the trace. */
  look() {
    const reading = this.reading(this.place);
    this.message = reading ? "" : `no state was found at x0 = ${this.place.x0.toFixed(4)}`;
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
    const { path } = this.sticking;
    const { clamp, x0, side } = place;
    const state = stateAt(path, Math.max(path.x0Pulled, Math.min(path.x0End, x0)));
    if (!state) return null;
    const { fx, fy, m, phi1, sc } = state;
    const { x1, way } = path.branch;
    return {
      ...place,
      contact: way * clamp + side * (x1 - way * x0),
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
