// A measured recording, dropped onto the page as a CSV file.

import { DEFAULTS } from "./settings.js";
import { factorOf, scaled } from "./units.js";

/** @type {[keyof Omit<Recording, "name">, string, Quantity][]} */
export const COLUMNS = [
  ["clamp", "footpoint", "length"],
  ["fx", "force_x", "force"],
  ["fy", "force_y", "force"],
  ["m", "moment_z", "moment"],
];

/** Samples of a recording that are drawn, at most. */
const MOST_SAMPLES = 4000;

/**
 * Read a recording: a header such as `footpoint [mm],force_x [N]`, perhaps below lines that begin with #, and a row for
 * each sample. The whisker, which may change later, converts columns with a unit to nondimensional values.
 * @type {(name: string, text: string) => { recording: (whisker: Whisker) => Recording } | { message: string }}
 */
export function readRecording(name, text) {
  const lines = text.replace(/^\uFEFF/, "").trimEnd().split(/\r\n|\n|\r/);
  const first = lines.findIndex((line) => !line.startsWith("#"));
  const [head = "", ...rows] = lines.slice(first);
  const separator = [",", ";", "\t"].find((sign) => head.includes(sign)) ?? ",";
  const titles = head.split(separator).map((title) => title.replace(/"/g, "").trim());
  /** @type {Recording} */
  const recording = { name, clamp: [], fx: [], fy: [], m: [] };
  /** @type {{ key: "clamp" | "fx" | "fy" | "m", index: number, factor: (whisker: Whisker) => number }[]} */
  const found = [];
  for (const [key, title, quantity] of COLUMNS) {
    const pattern = new RegExp(`^${title}\\s*(?:[[(](.*)[\\])])?$`);
    const index = titles.findIndex((text) => pattern.test(text));
    if (index < 0) continue;
    const unit = pattern.exec(titles[index])?.[1]?.trim() ?? "";
    found.push({ key, index, factor: (whisker) => factorOf(unit, quantity, whisker) });
    if (Number.isNaN(factorOf(unit, quantity, DEFAULTS))) {
      return { message: `${name}: “${unit}” is not a known unit of ${quantity}` };
    }
  }
  if (found[0]?.key !== "clamp" || found.length < 2) {
    const wanted = COLUMNS.map(([, title]) => title).join(", ");
    return { message: `${name}: the first line must name two or more of the columns ${wanted}; footpoint is required` };
  }
  const every = Math.ceil(rows.length / MOST_SAMPLES);
  for (const [number, row] of rows.entries()) {
    if (!row.trim()) continue;
    const cells = row.split(separator);
    for (const { key, index } of found) {
      const cell = (cells[index] ?? "").replace(/"/g, "").trim();
      const value = cell === "" || /^nan$/i.test(cell) ? NaN : Number(cell);
      if (Number.isNaN(value) && cell !== "" && !/^nan$/i.test(cell)) {
        return { message: `${name}, line ${first + number + 2}: “${cell}” is not a number` };
      }
      if (number % every === 0) recording[key].push(value);
    }
  }
  if (!recording.clamp.some(Number.isFinite)) return { message: `${name}: the file has no samples` };
  /** @param {Whisker} whisker */
  const converted = (whisker) => {
    const columns = found.map(({ key, factor }) => [key, scaled(recording[key], factor(whisker))]);
    return { ...recording, ...Object.fromEntries(columns) };
  };
  return { recording: converted };
}
