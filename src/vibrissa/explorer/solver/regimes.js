// The map of what a tip does: friction coefficients over the taper, at one height.

import { solvedPath, touch } from "./path.js";
import { demand } from "./rod/state.js";

/**
 * Solve the map, one taper at a time, so that a page can do so between its frames.
 * @type {(rod: Omit<Given, "theta">, tapers: number[]) => Generator<Division, void, void>}
 */
export function* divisions(rod, tapers) {
  let nodes = 0;
  for (const theta of tapers) {
    const { path } = solvedPath({ ...rod, theta }, nodes);
    const found = path && touch(path);
    // Past the lock no tip slips any more: what it touches there divides nothing.
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
