// What happens, in words.

import { isMirrored } from "../solver/motion.js";
import { spelled } from "./svg.js";

/** @import { Settings } from "./settings.js" */
/** @import { Event, Place, Sticking } from "../solver/motion.js" */
/** @import { State } from "../solver/rod/state.js" */

/**
 * Say what happened.
 *
 * @param {Event} event
 * @param {Sticking} sticking
 * @param {(length: number) => string} length Spells a length with its unit.
 * @returns {string}
 */
export function told(event, { path, friction }, length) {
  const at = length(event.x0);
  const mu0 = `μ0 = ${spelled(friction.mu0, 3)}`;
  switch (event.what) {
    case "slips":
      return event.x0 > 0
        ? `The tip slips ahead at x0 = ${at} and comes to rest at x0 = ${length(event.rest)}.`
        : `The clamp pulls: the tip slips at x0 = ${at} and comes to rest at x0 = ${length(event.rest)}.`;
    case "locks":
      return `The tip locks: ${mu0} is more than the tip can ever need, ${spelled(path.muLock, 4)}.`;
    case "unlocks":
      return "The tip is no longer locked.";
    case "lies down":
      return `The rod lies down on the surface at x0 = ${at}.`;
    case "peels off":
      return `The rod peels off the surface at x0 = ${at}; its tip alone touches.`;
    case "passes through":
      return `At x0 = ${at} the tip is parallel to the surface; beyond, a real rod would lie down (line contact).`;
    case "comes free":
      return "The tip touches from below again.";
    case "swings":
      return isMirrored(path)
        ? "The clamp passes under the contact point: the round rod swings aside, and trails behind."
        : `At x0 = ${at} the round rod swings aside. Where it goes is not computed in this mounting. The model begins anew at α = 0.`;
    case "slips back":
      return `The tip slips back at x0 = ${at}. The model begins anew at α = 0.`;
    case "snaps":
      return `The rod snaps through at x0 = ${at}: there is no equilibrium beyond. The model begins anew at α = 0.`;
    case "lifts":
      return `The tip lifts off at x0 = ${at}: the surface would have to pull. The model begins anew at α = 0.`;
    case "inadmissible":
      return `At x0 = ${at} ${path.pushed.why}. The model begins anew at α = 0.`;
    case "unknown":
      return `No state was found beyond x0 = ${at}. The model begins anew at α = 0.`;
  }
}

/**
 * Say how the rod is.
 *
 * @param {Sticking} sticking
 * @param {Place} place
 * @param {State} state
 * @param {number} x0
 * @returns {string}
 */
export function condition(sticking, place, state, x0) {
  const parts = [x0 > sticking.lock ? "locked" : "sticks"];
  if (x0 < 0) parts.push(place.side > 0 ? "pulled" : "dragged");
  if (place.side < 0) parts.push("behind the clamp");
  if (state.contact === "line") parts.push("lies on the surface");
  else if (state.phi1 < 0) parts.push("passes through the surface");
  return parts.join(", ");
}

/**
 * Say how the rod is mounted.
 *
 * @param {Settings} settings
 * @returns {string}
 */
export function mounted({ beta, compliance, kappa0, kappa1, delta }) {
  const parts = [];
  if (beta !== 0) parts.push(`the clamp is inclined by ${number(Math.abs(beta))}° (${beta > 0 ? "leans back" : "leans forward"})`);
  if (compliance !== 0) parts.push(`the clamp yields, c = ${number(compliance)}`);
  if (kappa0 !== 0 || kappa1 !== 0) {
    const tip = kappa0 + kappa1;
    parts.push(`the rod is curved by nature, ${number(kappa0)}/L at the clamp and ${number(tip)}/L at the tip`);
  }
  if (delta !== 0) parts.push(`the stage ${delta > 0 ? "approaches" : "leaves"} the surface at ${number(Math.abs(delta))}°`);
  return parts.length ? parts.join("; ") : "ideal: an upright, rigid clamp, a straight rod, a level stage";
}

/**
 * @param {number} value
 * @returns {string} With up to three decimals.
 */
function number(value) {
  return String(Number(value.toFixed(3))).replace("-", "−");
}
