// What a user sets, and the same as text in the page's address.

/** @import { Mounting } from "../solver/rod/mounting.js" */
/** @import { Contact } from "../solver/rod/state.js" */
/** @import { SlipLaw } from "../solver/motion.js" */

/**
 * @typedef {object} Settings
 * @property {number} theta
 * @property {number} eta
 * @property {number} mu0
 * @property {number} dx0
 * @property {number} ratio
 * @property {Contact} contact
 * @property {"round" | "planar"} section
 * @property {SlipLaw} law
 * @property {"none" | "si"} units
 * @property {number} modulus
 * @property {number} diameter
 * @property {number} length
 * @property {number} beta Degrees.
 * @property {number} compliance
 * @property {number} kappa0
 * @property {number} kappa1
 * @property {number} delta Degrees.
 */

/** @type {Settings} */
export const DEFAULTS = {
  theta: 2,
  eta: 0.85,
  mu0: 0.4,
  dx0: 0.001,
  ratio: 0.8,
  contact: "point",
  section: "round",
  law: "free",
  units: "none",
  modulus: 210,
  diameter: 1,
  length: 100,
  beta: 0,
  compliance: 0,
  kappa0: 0,
  kappa1: 0,
  delta: 0,
};

/**
 * A number that a user sets.
 *
 * @typedef {object} NumberField
 * @property {"theta" | "eta" | "mu0" | "dx0" | "ratio" | "modulus" | "diameter" | "length" | "beta" | "compliance" | "kappa0" | "kappa1" | "delta"} key
 * @property {string} symbol
 * @property {string} label
 * @property {number} min
 * @property {number} max
 * @property {number} step
 * @property {string} [unit]
 */

/** @type {NumberField[]} */
export const NUMBERS = [
  { key: "theta", symbol: "θ", label: "taper, base over tip", min: 1, max: 20, step: 0.01 },
  { key: "eta", symbol: "η", label: "height of the surface", min: 0.3, max: 0.99, step: 0.005, unit: "L" },
  { key: "mu0", symbol: "μ0", label: "static friction", min: 0.02, max: 2, step: 0.005 },
  { key: "dx0", symbol: "Δx0", label: "step of the clamp", min: 0.0001, max: 0.05, step: 0.0001, unit: "L" },
  { key: "ratio", symbol: "μk/μ0", label: "kinetic over static friction", min: 0.05, max: 1, step: 0.01 },
];

/** @type {NumberField[]} */
export const MOUNTING_NUMBERS = [
  { key: "beta", symbol: "β", label: "inclination of the clamp", min: -20, max: 20, step: 0.1, unit: "°" },
  { key: "compliance", symbol: "c", label: "its turn per moment, L/(E·I0)", min: 0, max: 0.5, step: 0.005 },
  { key: "kappa0", symbol: "κ0", label: "natural curvature at the clamp", min: -1, max: 1, step: 0.01, unit: "1/L" },
  { key: "kappa1", symbol: "κ1", label: "its growth up to the tip", min: -1, max: 1, step: 0.01, unit: "1/L" },
  { key: "delta", symbol: "δ", label: "angle of the stage", min: -6, max: 6, step: 0.1, unit: "°" },
];

/** @type {NumberField[]} */
export const ROD_NUMBERS = [
  { key: "modulus", symbol: "E", label: "Young’s modulus", min: 0.001, max: 1000, step: 0.001, unit: "GPa" },
  { key: "diameter", symbol: "d0", label: "diameter of the base", min: 0.001, max: 100, step: 0.001, unit: "mm" },
  { key: "length", symbol: "L", label: "length of the rod", min: 0.1, max: 10000, step: 0.1, unit: "mm" },
];

/**
 * A setting that is one of some words.
 *
 * @typedef {object} ChoiceField
 * @property {"contact" | "section" | "law" | "units"} key
 * @property {string} label
 * @property {[string, string][]} words The word, and what the page says for it.
 */

/** @type {ChoiceField[]} */
export const CHOICES = [
  { key: "contact", label: "Contact", words: [["point", "Tip"], ["line", "Line"]] },
  { key: "section", label: "Section", words: [["round", "Round"], ["planar", "Planar"]] },
  { key: "law", label: "A slip ends", words: [["free", "At α = 0"], ["kinetic", "Kinetic"], ["energy", "Energy"]] },
  { key: "units", label: "Units", words: [["none", "L, E·I0"], ["si", "SI"]] },
];

/**
 * @param {Settings} settings
 * @returns {Mounting}
 */
export function mountingOf({ beta, compliance, kappa0, kappa1, delta }) {
  const radian = Math.PI / 180;
  return { angle: radian * beta, compliance, curvature: [kappa0, kappa1], stage: radian * delta };
}

/**
 * Settings and clamp position as the text after the # of an address.
 *
 * @param {Settings} settings
 * @param {number} clamp
 * @returns {string}
 */
export function toAddress(settings, clamp) {
  const changed = Object.entries(settings).filter(
    ([key, value]) =>
      ["theta", "eta", "mu0"].includes(key) ||
      value !== DEFAULTS[/** @type {keyof Settings} */ (key)],
  );
  const texts = changed.map(([key, value]) => [key, String(value)]);
  if (clamp !== 0) texts.push(["clamp", String(Number(clamp.toFixed(6)))]);
  return new URLSearchParams(texts).toString();
}

/**
 * The inverse; what is missing is as by default, and what is not allowed is told.
 *
 * @param {string} text
 * @returns {{ settings: Settings, clamp: number, mistakes: string[] } | null} null where the text is
 *   none of the explorer's.
 */
export function fromAddress(text) {
  const given = new URLSearchParams(text.replace(/^#/, ""));
  if (!given.has("theta")) return null;
  const settings = { ...DEFAULTS };
  /** @type {string[]} */
  const mistakes = [];
  for (const { key, symbol, min, max } of [...NUMBERS, ...MOUNTING_NUMBERS, ...ROD_NUMBERS]) {
    const word = given.get(key);
    if (word === null) continue;
    const value = Number(word);
    if (word.trim() && value >= min && value <= max) settings[key] = value;
    else mistakes.push(`${symbol} must lie between ${min} and ${max}, the address has “${word}”`);
  }
  for (const { key, words } of CHOICES) {
    const word = given.get(key);
    if (word === null) continue;
    const known = words.some(([name]) => name === word);
    if (known) Object.assign(settings, { [key]: word });
    else mistakes.push(`${key} must be one of ${words.map(([name]) => name).join(", ")}`);
  }
  const clamp = Number(given.get("clamp") ?? 0);
  return { settings, clamp: Number.isFinite(clamp) ? Math.max(-5, Math.min(50, clamp)) : 0, mistakes };
}
