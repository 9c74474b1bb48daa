// Messages: events, conditions and parameters in words.

import { isMirrored } from "../solver/motion.js";
import { CHOICES, lawOf, MOUNTING_NUMBERS, NUMBERS, ROD_NUMBERS, WAVE_NUMBERS, waveOf } from "./settings.js";
import { spelled } from "./svg.js";

const ANEW = "The model started again at α = 0.";

/**
 * The message for an event; `length` formats a length with its unit.
 * @type {(event: Incident, sticking: Sticking, length: (x0: number) => string) => string}
 */
export function told(event, { path, friction, ahead }, length) {
  const at = length(event.x0);
  switch (event.what) {
    case "slips": {
      const { slid } = event;
      if (slid) return `The tip slipped by ${length(Math.abs(slid.to - slid.from))}, to ${length(slid.to)}.`;
      const start = `${event.x0 > 0 ? "The tip" : "Pulled by the clamp, the tip"} slipped at x0 = ${at}`;
      return event.rest === 0 ? `${start}; x0 reset to 0.` : `${start} and stopped at x0 = ${length(event.rest)}.`;
    }
    case "flies off":
      return `The slip at x0 = ${at} released so much energy that the tip lifted off or passed the last known state. ${ANEW}`;
    case "is lost":
      return `The tip did not come to rest after its slip at x0 = ${at}: it lifted off, or passed the last known state. ${ANEW}`;
    case "slides along":
      return `The tip slid along with the clamp at x0 = ${at}: kinetic friction is as large as static friction.`;
    case "locks":
      if (ahead !== friction.mu0) return "The tip locked: friction and the slope under it hold it, and pushing cannot make it slip.";
      return `μ0 = ${spelled(friction.mu0, 3)} is above μ_lock = ${spelled(path.muLock, 4)}: pushing cannot make the tip slip.`;
    case "unlocks":
      return "The tip was locked and no longer is.";
    case "lies down":
      return `The rod lay down on the surface at x0 = ${at}.`;
    case "peels off":
      return `The rod peeled off the surface at x0 = ${at}; only its tip touches.`;
    case "passes through":
      return `The tip became parallel to the surface at x0 = ${at}. Beyond, a real rod would lie down (line contact).`;
    case "comes free":
      return "The rod came free: it no longer penetrates the surface.";
    case "swings":
      return isMirrored(path)
        ? "The clamp passed under the contact point: the round rod buckled laterally and now trails behind."
        : `The round rod buckled laterally at x0 = ${at}. Where it went is not computed in this mounting. ${ANEW}`;
    case "slips back":
      return `The tip slipped back at x0 = ${at}. ${ANEW}`;
    case "snaps":
      return `The rod snapped through at x0 = ${at}: there is no equilibrium beyond. ${ANEW}`;
    case "lifts":
      return `The tip lifted off at x0 = ${at}: the surface would have to pull. ${ANEW}`;
    case "inadmissible":
      return `At x0 = ${at} ${path.pushed.why}. ${ANEW}`;
    case "lost":
      return `No state was found beyond x0 = ${at}. ${ANEW}`;
  }
}

/** Condition of the rod: it sticks, is pulled, lies on the surface, ... @type {(sticking: Sticking, reading: Reading) => string} */
export function condition(sticking, { x0, side, state }) {
  const parts = [x0 > sticking.lock ? "locked" : "sticks"];
  if (x0 < 0) parts.push(side > 0 ? "pulled" : "dragged");
  if (side < 0) parts.push("behind the clamp");
  if (state.contact === "line") parts.push("lies on the surface");
  else if (state.phi1 < 0) parts.push("would penetrate the surface");
  return parts.join(", ");
}

/** Fields with their values. @type {(fields: NumberField[], settings: Settings) => string[]} */
function named(fields, settings) {
  return fields.map(({ key, symbol, unit = "" }) => {
    return `${symbol} = ${String(settings[key]).replace("-", "−")}${unit === "°" ? "" : " "}${unit}`.trim();
  });
}

/** @type {(settings: Settings) => string[]} */
function deviations(settings) {
  return named(MOUNTING_NUMBERS.filter(({ key }) => settings[key] !== 0), settings);
}

/** How the rod is mounted. @type {(settings: Settings) => string} */
export function mounted(settings) {
  return deviations(settings).join(", ") || "ideal: upright rigid clamp, straight rod, level stage";
}

/** The surface. @type {(settings: Settings) => string} */
export function surfaced(settings) {
  return waveOf(settings) ? named(WAVE_NUMBERS, settings).join(", ") : "a plane";
}

/** A short name of a rod, for the legend of its curve. @type {(settings: Settings) => string} */
export function rodName(settings) {
  const contact = settings.contact === "line" ? ["line contact"] : [];
  const section = settings.section === "planar" ? ["planar"] : [];
  return [...named(NUMBERS.slice(0, 2), settings), ...contact, ...section, ...deviations(settings)].join(", ");
}

/** All parameters, as the title of an export. @type {(settings: Settings) => string} */
export function parameters(settings) {
  const law = lawOf(settings);
  const used = { ...settings, law };
  const numbers = NUMBERS.filter(({ key }) => key !== "ratio" || law !== "free");
  const chosen = CHOICES.filter(({ key }) => key === "contact" || key === "section" || key === "law");
  const words = chosen.map(({ key, label, words }) => {
    return `${label.toLowerCase()} ${words.find(([word]) => word === used[key])?.[1].toLowerCase()}`;
  });
  const rod = settings.units === "si" ? named(ROD_NUMBERS, settings) : [];
  const wave = waveOf(settings) ? named(WAVE_NUMBERS, settings) : [];
  return [...named(numbers, settings), ...words, ...deviations(settings), ...wave, ...rod].join(", ");
}
