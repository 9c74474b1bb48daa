// Values of the model, nondimensional or in SI units of a chosen rod.

/**
 * The rod of a sensor: what turns units of L and E·I0 into SI units.
 *
 * @typedef {object} Whisker
 * @property {number} modulus GPa.
 * @property {number} diameter Of the base, mm.
 * @property {number} length mm.
 */

/**
 * @typedef {"length" | "force" | "moment" | "energy" | "number" | "angle"} Quantity
 */

/**
 * How values are shown.
 *
 * @typedef {object} Units
 * @property {Record<Quantity, number>} scale What a nondimensional value is multiplied with.
 * @property {Record<Quantity, string>} name
 */

/** @type {Units} */
export const NONDIMENSIONAL = {
  scale: { length: 1, force: 1, moment: 1, energy: 1, number: 1, angle: 1 },
  name: {
    length: "L",
    force: "E·I0/L²",
    moment: "E·I0/L",
    energy: "E·I0/L",
    number: "",
    angle: "rad",
  },
};

/**
 * Units of a rod: mm, mN and µN·m, or N and N·mm where the forces are large.
 *
 * @param {Whisker} whisker
 * @returns {Units}
 */
export function unitsOf({ modulus, diameter, length }) {
  // GPa = 10³ N/mm²
  const stiffness = (1e3 * modulus * Math.PI * diameter ** 4) / 64;
  const force = stiffness / length ** 2;
  const moment = stiffness / length;
  const [large, heavy] = [force >= 0.1, moment >= 0.1];
  return {
    scale: {
      length,
      force: large ? force : 1e3 * force,
      moment: heavy ? moment : 1e3 * moment,
      energy: heavy ? moment : 1e3 * moment,
      number: 1,
      angle: 1,
    },
    name: {
      length: "mm",
      force: large ? "N" : "mN",
      moment: heavy ? "N·mm" : "µN·m",
      energy: heavy ? "mJ" : "µJ",
      number: "",
      angle: "rad",
    },
  };
}

/** @type {Record<string, [Quantity, number]>} Units of a recording: to mm, N and N·mm. */
const KNOWN = {
  m: ["length", 1e3],
  cm: ["length", 10],
  mm: ["length", 1],
  um: ["length", 1e-3],
  N: ["force", 1],
  mN: ["force", 1e-3],
  uN: ["force", 1e-6],
  "N*m": ["moment", 1e3],
  "mN*m": ["moment", 1],
  "N*mm": ["moment", 1],
  "uN*m": ["moment", 1e-3],
  "mN*mm": ["moment", 1e-3],
};

/**
 * Factor of a unit to nondimensional values of a rod.
 *
 * @param {string} unit As a recording writes it; empty for nondimensional values.
 * @param {Quantity} quantity
 * @param {Whisker} whisker
 * @returns {number} NaN where the unit is not one of this quantity.
 */
export function factorOf(unit, quantity, { modulus, diameter, length }) {
  if (unit === "" || unit === "1") return 1;
  const plain = unit.replace(/[µμ]/g, "u").replace(/[·⋅ ]/g, "*");
  const [kind, factor] = KNOWN[plain] ?? ["number", NaN];
  if (kind !== quantity) return NaN;
  const stiffness = (1e3 * modulus * Math.PI * diameter ** 4) / 64;
  const one = { length, force: stiffness / length ** 2, moment: stiffness / length };
  return factor / (quantity === "length" ? one.length : quantity === "force" ? one.force : one.moment);
}
