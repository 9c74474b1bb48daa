// The map of regimes: friction coefficients at which the tip locks or the rod touches, over the taper.

import { solvedPath, touch } from "./path.js";
import { demand } from "./rod/state.js";

/** Tapers of the map: up to 8, or up to 20 if the taper of the rod exceeds 8. */
const TAPERS = Array.from({ length: 29 }, (_, k) => 1 + 0.25 * k);
const MORE_TAPERS = Array.from({ length: 39 }, (_, k) => 1 + 0.5 * k);

/** The map at the height and mounting of a rod, solved between the frames of a page. */
export class RegimeMap {
  constructor() {
    /** @type {Division[]} */
    this.divisions = [];
    this.key = "";
  }

  /** Continue until a time (ms); returns whether a row was added. @type {(given: Given, until: number) => boolean} */
  solve({ theta, ...rod }, until) {
    const tapers = theta > 8 ? MORE_TAPERS : TAPERS;
    const key = JSON.stringify([rod, tapers.length]);
    if (key !== this.key) {
      [this.key, this.divisions] = [key, []];
      this.solving = divisions(rod, tapers);
    }
    const before = this.divisions.length;
    while (this.solving && performance.now() < until) {
      const { value } = this.solving.next();
      if (value) this.divisions.push(value);
      else this.solving = undefined;
    }
    return this.divisions.length > before;
  }
}

/**
 * Solve the map, one taper at a time.
 * @type {(rod: Omit<Given, "theta">, tapers: number[]) => Generator<Division, void, void>}
 */
function* divisions(rod, tapers) {
  let nodes = 0;
  for (const theta of tapers) {
    const { path } = solvedPath({ ...rod, theta }, nodes);
    const found = path && touch(path);
    // A touch past the lock divides no regimes, as the tip does not slip there.
    const after = path?.lock && found && found.offset < path.lock.state.offset;
    const state = after ? null : found;
    nodes = path ? path.branch.rod.nodes : 0;
    yield {
      theta,
      lock: path ? path.muLock : NaN,
      touch: state ? Math.max(0, demand(state)) : NaN,
    };
  }
}
