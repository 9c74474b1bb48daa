// The rod on the page: settings, solved path, positions of clamp and tip, and readings.

import { isMirrored, isOblique, moved, stickingOf } from "../solver/motion.js";
import { HEIGHTS, sampled, solvedPath, stateAt } from "../solver/path.js";
import { demand } from "../solver/rod/state.js";
import { begunOn, movedOn, stateAbove, stickingOn, slopeOf, tipOn } from "../solver/wave.js";
import { CLAMP_RANGE, DEFAULTS, lawOf, mountingOf, waveOf } from "./settings.js";

/** Most readings of a trace; most parts of a move, with a reading each; samples of each step of a path. */
const MOST_READINGS = 1500;
const MOST_PARTS = 16;
const PARTS_OF_A_STEP = 4;
/** Most slips over which the slips in a wave are counted. */
export const MOST_SLIPS = 12;

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

/**
 * Places at which the last slips on a wave ended, after one more; a slip the other way begins anew.
 * @type {(rests: number[], slid: { from: number, to: number }) => number[]}
 */
function counted(rests, { from, to }) {
  const turns = rests.length > 1 && (rests[1] - rests[0]) * (to - from) < 0;
  return turns ? [to] : [...rests, to].slice(-1 - MOST_SLIPS);
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
    /** Place of the tip on a wave; NaN on a plane. */
    this.contact = NaN;
    /** Places at which the last slips on a wave ended. @type {number[]} */
    this.rests = [];
    this.solve();
  }

  /**
   * Change settings, and return the events that this causes; a changed rod is solved anew.
   * @type {(change: Partial<Settings>) => Incident[]}
   */
  change(change) {
    const { rod, friction, wave } = this;
    this.settings = { ...this.settings, ...change };
    if (differ([rod, wave], [this.rod, this.wave]) || !this.sticking) {
      this.solve();
      return [];
    }
    if (!differ(friction, this.friction)) return [];
    this.rests = [];
    const { path } = this.sticking;
    const { x0, side } = this.place;
    this.sticking = this.wave
      ? stickingOn(path, this.friction, side * slopeOf(this.wave, this.contact), x0)
      : stickingOf(path, this.friction, x0);
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

  /** The wave of the surface; null on a plane. */
  get wave() {
    return waveOf(this.settings);
  }

  /**
   * Solve the path of the rod, and put clamp and tip where they were. On a wave the tip is put at a place, or where a
   * scan begins.
   */
  solve(contact = NaN) {
    const { clamp, x0, side } = this.place;
    this.trace = [];
    this.rests = [];
    if (this.wave) {
      this.beginOn(clamp, contact, side);
      if (this.sticking) this.look();
      return;
    }
    this.contact = NaN;
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
    this.follow(path && stickingOf(path, this.friction, x0));
  }

  /**
   * Solve the period of a tip at a place of the wave, or where a scan begins.
   * @type {(clamp: number, contact?: number, side?: number) => void}
   */
  beginOn(clamp, contact = NaN, side = 1) {
    const ground = this.ground;
    if (typeof ground === "string") return this.stand(null, ground);
    const tip = Number.isNaN(contact) ? begunOn(ground, clamp) : tipOn(ground, clamp, contact, side);
    if (typeof tip === "string") this.stand(null, tip);
    else this.stand(tip, "");
  }

  /** Surface and rod with their wave; a message if the explorer does not have this case. @returns {Ground | string} */
  get ground() {
    const { rod, wave, friction, nodes } = this;
    if (!wave) return "there is no wave";
    if (rod.contact === "line" || rod.mounting.stage !== 0) {
      return "on a wave only the tip may touch, and the stage must be level: choose contact Tip and δ = 0, or amplitude 0";
    }
    return { given: rod, wave, friction, nodes };
  }

  /** Take over a tip on the wave; without one, the message says why. @type {(tip: Tip | null, message: string) => void} */
  stand(tip, message) {
    this.message = message;
    this.contact = tip ? tip.contact : NaN;
    if (tip) this.place = tip.place;
    if (!tip || tip.sticking !== this.sticking) this.follow(tip && tip.sticking);
  }

  /** Take over a solved period. @type {(sticking: Sticking | null) => void} */
  follow(sticking) {
    this.nodes = sticking ? sticking.path.branch.rod.nodes : 0;
    // Reduce the number, so that later rods do not keep nodes that only one rod needed.
    if (this.nodes > 30) this.nodes = Math.round(0.7 * this.nodes);
    this.sticking = sticking;
    /** @type {Curve | null} */
    this.curve = sticking && sampled(sticking.path, PARTS_OF_A_STEP);
  }

  /**
   * Restore positions of clamp and tip; on a wave the tip is at `contact`, or where a scan begins.
   * @type {(clamp: number, x0: number, side: number, contact?: number) => void}
   */
  restore(clamp, x0, side, contact = NaN) {
    this.place = { clamp, x0, side };
    this.solve(contact);
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
    if (this.wave) return this.partOn(clamp, stepped);
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

  /** A part of a move on the wave. @type {(clamp: number, stepped: boolean) => Incident[]} */
  partOn(clamp, stepped) {
    const { sticking, contact, place, ground } = this;
    if (!sticking || typeof ground === "string") {
      // Without a solved period, one begins anew where the clamp is to be, if one can.
      this.beginOn(clamp);
      if (this.sticking) this.look();
      return [];
    }
    const { tip, events, message } = movedOn(ground, { sticking, contact, place }, clamp, stepped);
    const jump = events.find(({ what }) => what === "slips" || what === "swings");
    if (jump && !stepped) {
      // The last reading before the jump.
      this.place = { ...place, clamp: jump.clamp, x0: jump.x0 };
      this.look();
    }
    if (tip?.contact !== contact) this.rests = jump?.slid ? counted(this.rests, jump.slid) : [];
    this.stand(tip, message);
    if (!this.sticking) return events;
    this.look();
    return this.place.clamp === clamp ? events : [...events, ...this.partOn(clamp, stepped)];
  }

  /** Angle (rad) by which the slope under the tip turns its friction cone: atan h', mirrored behind the clamp. */
  get inclination() {
    return this.wave ? Math.atan(this.place.side * slopeOf(this.wave, this.contact)) : 0;
  }

  /** Slips in a wave, of the last ones; NaN before the first. */
  get slipsInWave() {
    const { rests, wave } = this;
    if (!wave || rests.length < 2) return NaN;
    return ((rests.length - 1) * wave.wavelength) / Math.abs(rests[rests.length - 1] - rests[0]);
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
    const state = stateAt(path, Math.max(path.x0Pulled, Math.min(path.x0End, place.x0)));
    return state && this.readingOf(place, state);
  }

  /**
   * State and loads in a slip on the wave, where the tip is at a part of its way; null if no state is found.
   * @type {(slip: Incident, part: number) => Reading | null}
   */
  readingIn({ clamp, side, slid }, part) {
    const { sticking, ground } = this;
    if (!sticking || !slid || typeof ground === "string") return null;
    const contact = slid.from + part * (slid.to - slid.from);
    const state = stateAbove(ground, sticking.path.branch.rod, clamp, side, contact, slid.state);
    if (!state) return null;
    const x0 = sticking.path.branch.x1 + side * (clamp - contact);
    return this.readingOf({ clamp, x0, side }, state);
  }

  /** @type {(place: Place, state: State) => Reading | null} */
  readingOf(place, state) {
    if (!this.sticking) return null;
    const { path } = this.sticking;
    const { clamp, x0, side } = place;
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
