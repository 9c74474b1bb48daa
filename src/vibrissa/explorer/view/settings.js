// The settings of a user: fields with their ranges, and settings as text in the page's address.

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
  speed: "normal",
  labels: "on",
  modulus: 210,
  diameter: 1,
  length: 100,
  beta: 0,
  compliance: 0,
  kappa0: 0,
  kappa1: 0,
  stiffening: 0,
  bore: 0,
  delta: 0,
  amplitude: 0,
  wavelength: 0.025,
};

/** @type {NumberField[]} */
export const NUMBERS = [
  { key: "theta", symbol: "θ", label: "taper, base over tip", min: 1, max: 20, step: 0.01,
    help: "Diameter at the clamp over diameter at the tip. 1 is a cylinder; real whiskers are near 15." },
  { key: "eta", symbol: "η", label: "surface height", min: 0.3, max: 0.99, step: 0.005, unit: "L",
    help: "Distance from the clamp to the surface, in rod lengths. A lower surface bends the rod more." },
  { key: "mu0", symbol: "μ0", label: "static friction", min: 0.02, max: 2, step: 0.005,
    help: "Coefficient of static friction. The tip sticks while −tan α is less than μ0." },
  { key: "dx0", symbol: "Δx0", label: "step of the clamp", min: 0.0001, max: 0.05, step: 0.0001, unit: "L",
    help: "Distance by which Play, Step and the arrow keys move the clamp at a time." },
  { key: "ratio", symbol: "μk/μ0", label: "kinetic over static friction", min: 0.05, max: 1, step: 0.01,
    help: "Friction of a sliding tip, as a share of static friction." },
];

/** @type {NumberField[]} */
export const MOUNTING_NUMBERS = [
  { key: "beta", symbol: "β", label: "inclination of the clamp", min: -20, max: 20, step: 0.1, unit: "°",
    help: "Positive if the rod leans back, against the motion of the clamp." },
  { key: "compliance", symbol: "c", label: "rotational compliance", min: 0, max: 0.5, step: 0.005, unit: "L/EI0",
    help: "Angle by which the clamp turns for each unit of moment. 0 is a rigid clamp." },
  { key: "kappa0", symbol: "κ0", label: "natural curvature at the clamp", min: -1, max: 1, step: 0.01, unit: "1/L",
    help: "Curvature of the unloaded rod. A rod with negative curvature bends away from the surface." },
  { key: "kappa1", symbol: "κ1", label: "increase of κ0 up to the tip", min: -1, max: 1, step: 0.01, unit: "1/L",
    help: "The natural curvature changes linearly from κ0 at the clamp to κ0 + κ1 at the tip." },
  { key: "stiffening", symbol: "c1", label: "stiffening towards the tip", min: -0.9, max: 10, step: 0.01,
    help: "Young’s modulus changes linearly from E at the clamp to (1 + c1)·E at the tip." },
  { key: "bore", symbol: "b", label: "bore of a tube", min: 0, max: 0.95, step: 0.01, unit: "d0",
    help: "Inner diameter, the same along the rod. It must be below 1/θ, the diameter of the tip." },
  { key: "delta", symbol: "δ", label: "angle of the stage", min: -6, max: 6, step: 0.1, unit: "°",
    help: "Positive if the clamp approaches the surface as it moves. Each period then differs; slips are not animated." },
];

/** @type {NumberField[]} */
export const WAVE_NUMBERS = [
  { key: "amplitude", symbol: "A", label: "amplitude of a wave", min: 0, max: 0.01, step: 0.00001, unit: "L",
    help: "The surface has the height A·sin(2πx/λ). 0 is a plane. On a rod of 100 mm, 0.0001 L is 10 µm." },
  { key: "wavelength", symbol: "λ", label: "wavelength", min: 0.002, max: 0.5, step: 0.0005, unit: "L",
    help: "Near the distance of the slips on a plane, one slip ends in each wave: the slips lock to it." },
];

/** @type {NumberField[]} */
export const ROD_NUMBERS = [
  { key: "modulus", symbol: "E", label: "Young’s modulus", min: 0.001, max: 1000, step: 0.001, unit: "GPa",
    help: "Steel has about 210 GPa, a whisker about 3 GPa." },
  { key: "diameter", symbol: "d0", label: "diameter of the base", min: 0.001, max: 100, step: 0.001, unit: "mm",
    help: "Diameter of the rod at its clamp." },
  { key: "length", symbol: "L", label: "length of the rod", min: 0.1, max: 10000, step: 0.1, unit: "mm",
    help: "Length from the clamp to the tip." },
];

/** @type {ChoiceField[]} */
export const CHOICES = [
  { key: "contact", label: "Contact", words: [["point", "Tip"], ["line", "Line"]],
    help: "Tip: only the tip touches, as in the paper. Line: the rod may lie down on the surface." },
  { key: "section", label: "Section", words: [["round", "Round"], ["planar", "Planar"]],
    help: "A round rod buckles laterally once its clamp passes the tip. A planar one stays in its plane." },
  { key: "law", label: "Slip stops where", help: "Condition that ends a slip. The first one is the paper’s assumption.",
    words: [["free", "the tangential force is zero"], ["kinetic", "kinetic friction holds"], ["energy", "its energy is spent"]] },
  { key: "units", label: "Units", words: [["none", "L, E·I0"], ["si", "SI"]],
    help: "Units of the model, or SI units of a rod that you describe." },
  { key: "speed", label: "Speed", words: [["slow", "Slow"], ["normal", "Normal"], ["fast", "Fast"]],
    help: "Speed of Play and of each slip." },
  { key: "labels", label: "Labels", words: [["on", "On"], ["off", "Off"]],
    help: "Names of lengths, angles and forces in the drawing of the rod." },
];

/** Where the clamp can be (L). */
export const CLAMP_RANGE = { min: -5, max: 50 };
/** Curves that can be pinned at the same time. */
export const MOST_PINS = 3;
/** Clamp and tip in an address. */
const POSITIONS = [
  ...["clamp", "x0"].map((key) => ({ key, symbol: key, ...CLAMP_RANGE })),
  // The tip is within a rod's length of the clamp.
  { key: "tip", symbol: "tip", min: CLAMP_RANGE.min - 1, max: CLAMP_RANGE.max + 1 },
];
const SIDES = { key: "side", words: [["1"], ["-1"]] };

/** The law by which slips end: on an oblique stage always at α = 0. @type {(settings: Settings) => SlipLaw} */
export function lawOf({ law, delta }) {
  return delta === 0 ? law : "free";
}

/** The wave of the surface; null on a plane. @type {(settings: Settings) => Wave | null} */
export function waveOf({ amplitude, wavelength }) {
  return amplitude === 0 ? null : { amplitude, wavelength };
}

/** @type {(settings: Settings) => Mounting} */
export function mountingOf({ beta, compliance, kappa0, kappa1, stiffening, bore, delta }) {
  const radian = Math.PI / 180;
  const making = { powers: [stiffening], bore };
  return { angle: radian * beta, compliance, curvature: [kappa0, kappa1], stage: radian * delta, making };
}

/** The text after the # of an address. @type {(shared: Shared) => string} */
export function toAddress({ settings, clamp, x0, tip, side, pins }) {
  const texts = new URLSearchParams();
  for (const [key, value] of Object.entries(settings)) {
    const always = key === "theta" || key === "eta" || key === "mu0";
    if (always || value !== DEFAULTS[/** @type {keyof Settings} */ (key)]) texts.append(key, String(value));
  }
  if (clamp !== 0 || x0 !== 0) {
    // On a wave x0 is measured from another place in each period.
    const positions = Number.isNaN(tip) ? { clamp, x0 } : { clamp, tip };
    for (const [key, value] of Object.entries(positions)) texts.append(key, String(Number(value.toFixed(9))));
  }
  if (side < 0) texts.append("side", "-1");
  for (const pin of pins) {
    texts.append("pin", toAddress({ settings: pin, clamp: 0, x0: 0, tip: NaN, side: 1, pins: [] }));
  }
  return texts.toString();
}

/**
 * Read the text after the # of an address; `mistakes` lists what is not understood. null if it gives no key a value.
 * @type {(text: string) => (Shared & { mistakes: string[] }) | null}
 */
export function fromAddress(text) {
  const given = new URLSearchParams(text.replace(/^#/, ""));
  const numbers = [...NUMBERS, ...MOUNTING_NUMBERS, ...WAVE_NUMBERS, ...ROD_NUMBERS, ...POSITIONS];
  const choices = [...CHOICES, SIDES];
  if (![...given.values()].some(Boolean)) return null;
  const known = ["pin", ...[...numbers, ...choices].map(({ key }) => key)];
  const unknown = [...given.keys()].filter((key) => !known.includes(key));
  const mistakes = unknown.map((key) => `${key} in the address is not a known key`);
  const values = { ...DEFAULTS, clamp: 0, x0: NaN, tip: NaN, side: "1" };
  for (const field of [...numbers, ...choices]) {
    const word = given.get(field.key);
    if (word === null) continue;
    const { value, mistake } = "words" in field ? choiceOf(word, field) : numberOf(word, field);
    if (mistake) mistakes.push(`${"symbol" in field ? field.symbol : field.key} in the address: ${mistake}`);
    else Object.assign(values, { [field.key]: value });
  }
  const rods = given.getAll("pin");
  if (rods.length > MOST_PINS) mistakes.push(`only the first ${MOST_PINS} pins of the address are shown`);
  /** @type {Settings[]} */
  const pins = [];
  for (const pin of rods.slice(0, MOST_PINS).map(fromAddress)) {
    if (pin) pins.push(pin.settings);
    mistakes.push(...(pin ? pin.mistakes : ["a pin in the address has no settings"]));
  }
  const { clamp, x0, tip, side, ...settings } = values;
  return { settings, clamp, x0, tip, side: Number(side), pins, mistakes };
}

/** @type {(word: string, field: { words: string[][] }) => { value: string, mistake: string }} */
function choiceOf(value, { words }) {
  const names = words.map(([name]) => name);
  return { value, mistake: names.includes(value) ? "" : `must be one of ${names.join(", ")}` };
}

/**
 * Read a typed number, with a decimal point or comma; `mistake` is empty if the number is allowed.
 * @type {(text: string, field: Pick<NumberField, "min" | "max">) => { value: number, mistake: string }}
 */
export function numberOf(text, { min, max }) {
  const plain = text.trim().replace("−", "-").replace(",", ".");
  const value = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
  const range = `from ${min} to ${max}`;
  if (Number.isNaN(value)) return { value, mistake: text.trim() ? `“${text.trim()}” is not a number, ${range}` : `a number ${range}` };
  return { value, mistake: value >= min && value <= max ? "" : `must be ${range}` };
}
