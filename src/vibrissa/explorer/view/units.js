// Values of the model, nondimensional or in SI units of a chosen rod.

/** @type {Units} */
export const NONDIMENSIONAL = {
  scale: { length: 1, force: 1, moment: 1, energy: 1, number: 1, angle: 1 },
  name: { length: "L", force: "E·I0/L²", moment: "E·I0/L", energy: "E·I0/L", number: "", angle: "rad" },
};

/** The name of a unit as the commands write it. @type {(name: string) => string} */
export function plainName(name) {
  return name.replace("²", "^2").replaceAll("·", "*").replace("µ", "u").replace("°", "deg");
}

/** @type {(values: number[], factor: number) => number[]} */
export const scaled = (values, factor) => values.map((value) => factor * value);

/** L, E·I0/L² and E·I0/L in mm, N and N·mm. @type {(whisker: Whisker) => Record<"length" | "force" | "moment", number>} */
function scalesOf({ modulus, diameter, length, bore }) {
  // GPa = 10³ N/mm²
  const stiffness = (1e3 * modulus * Math.PI * diameter ** 4 * (1 - bore ** 4)) / 64;
  return { length, force: stiffness / length ** 2, moment: stiffness / length };
}

/** Units of a rod: mm, mN and µN·m, or N and N·mm where the forces are large. @type {(whisker: Whisker) => Units} */
export function unitsOf(whisker) {
  const { length, force, moment } = scalesOf(whisker);
  const forces = force >= 0.1 ? { scale: force, name: "N" } : { scale: 1e3 * force, name: "mN" };
  const isHeavy = moment >= 0.1;
  const work = isHeavy ? moment : 1e3 * moment;
  return {
    scale: { ...NONDIMENSIONAL.scale, length, force: forces.scale, moment: work, energy: work },
    name: {
      ...NONDIMENSIONAL.name,
      length: "mm",
      force: forces.name,
      moment: isHeavy ? "N·mm" : "µN·m",
      energy: isHeavy ? "mJ" : "µJ",
    },
  };
}

/** @type {Record<string, ["length" | "force" | "moment", number]>} Units of a recording: to mm, N and N·mm. */
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
 * Factor from a unit, as a recording writes it, to nondimensional values of a rod; 1 if the unit is empty,
 * NaN if it is not a unit of this quantity.
 * @type {(unit: string, quantity: Quantity, whisker: Whisker) => number}
 */
export function factorOf(unit, quantity, whisker) {
  const plain = unit.replace(/[µμ]/g, "u").replace(/[·⋅ ]/g, "*").replace("Nm", "N*m");
  if (plain === "" || plain === "1" || plain === plainName(NONDIMENSIONAL.name[quantity])) return 1;
  const known = KNOWN[plain];
  return known?.[0] === quantity ? known[1] / scalesOf(whisker)[known[0]] : NaN;
}
