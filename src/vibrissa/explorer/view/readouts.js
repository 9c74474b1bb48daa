// Numbers below the rod, each with its name and unit.

import { force, inclination } from "../solver/rod/state.js";
import { element } from "./controls.js";
import { significant, withoutNoise, write } from "./svg.js";

/** Number of readings that are always shown; the others can be unfolded. */
const FIRST = 6;
/** @type {[string, string, Quantity, (view: View) => number][]} */
const READOUTS = [
  ["clamp", "position of the clamp", "length", ({ now }) => now.clamp],
  ["x0", "displacement x0", "length", ({ now }) => now.x0],
  ["slip", "exact onset x0,slip", "length", ({ sticking }) => onsetOf(sticking)],
  ["step", "last sticking step x0,max", "length", ({ sticking, settings }) => lastStep(onsetOf(sticking), settings.dx0)],
  ["lock", "critical friction μ_lock", "number", ({ sticking }) => sticking.path.muLock],
  ["f", "contact force f", "force", ({ now }) => force(now.state)],
  ["alpha", "inclination of f, α", "angle", ({ now }) => now.side * inclination(now.state)],
  ["phi1", "slope at the contact φ1", "angle", ({ now }) => now.phi1],
  ["sc", "contact at arc length s_c", "length", ({ now }) => now.sc],
  ["fx", "load on the clamp Fx", "force", ({ now }) => now.fx],
  ["fy", "load on the clamp Fy", "force", ({ now }) => now.fy],
  ["m", "moment on the clamp M", "moment", ({ now }) => now.m],
  ["energy", "bending energy", "energy", ({ now }) => now.energy],
];

/** The exact onset of slip ahead; NaN where the tip does not slip. @type {(sticking: Sticking) => number} */
export function onsetOf({ high, highBy }) {
  return highBy === "slips" ? high : NaN;
}

/** The largest multiple of a step that does not pass an onset. @type {(onset: number, step: number) => number} */
export function lastStep(onset, step) {
  // An onset is known to about 1e-12: a step that ends on it counts.
  return Math.floor((onset + 1e-12) / step) * step;
}

export class Readouts {
  /**
   * @param {HTMLElement} place
   * @param {HTMLElement} more Place of the readings that can be unfolded.
   */
  constructor(place, more) {
    this.outputs = READOUTS.map(([key, name, quantity, read], i) => {
      const [value, unit] = [element("span", { "data-value": key }), element("small", {})];
      (i < FIRST ? place : more).append(element("div", {}, element("dt", {}, name), element("dd", {}, value, " ", unit)));
      return { value, unit, quantity, read };
    });
  }

  /** @param {View} view */
  show(view) {
    const { scale, name } = view.units;
    for (const { value, unit, quantity, read } of this.outputs) {
      write(value, significant(scale[quantity] * withoutNoise(read(view))));
      write(unit, name[quantity]);
    }
  }
}
