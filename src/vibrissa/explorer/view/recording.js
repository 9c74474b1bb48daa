// A measured recording, dropped onto the page as a CSV file.

import { factorOf } from "./units.js";

/** @type {[keyof Omit<Recording, "name">, string, Quantity][]} */
export const COLUMNS = [
  ["clamp", "footpoint", "length"],
  ["fx", "force_x", "force"],
  ["fy", "force_y", "force"],
  ["m", "moment_z", "moment"],
];

/**
 * Read a recording: a header such as `footpoint [mm],force_x [N]`, and a row for each sample. The whisker
 * converts columns with a unit to nondimensional values.
 * @type {(name: string, text: string, whisker: Whisker) => { recording: Recording } | { message: string }}
 */
export function readRecording(name, text, whisker) {
  const [head = "", ...rows] = text.replace(/^\uFEFF/, "").trimEnd().split(/\r\n|\n|\r/);
  const separator = [",", ";", "\t"].find((sign) => head.includes(sign)) ?? ",";
  const titles = head.split(separator).map((title) => title.replace(/"/g, "").trim());
  /** @type {Recording} */
  const recording = { name, clamp: [], fx: [], fy: [], m: [] };
  const found = [];
  for (const [key, title, quantity] of COLUMNS) {
    const pattern = new RegExp(`^${title}\\s*(?:[[(](.*)[\\])])?$`);
    const index = titles.findIndex((text) => pattern.test(text));
    if (index < 0) continue;
    const unit = pattern.exec(titles[index])?.[1]?.trim() ?? "";
    const factor = factorOf(unit, quantity, whisker);
    if (Number.isNaN(factor)) {
      return { message: `${name}: “${unit}” is not a known unit of ${quantity}` };
    }
    found.push({ key, index, factor });
  }
  if (found[0]?.key !== "clamp" || found.length < 2) {
    const wanted = COLUMNS.map(([, title]) => title).join(", ");
    return { message: `${name}: the first line must name two or more of the columns ${wanted}; footpoint is required` };
  }
  for (const [number, row] of rows.entries()) {
    if (!row.trim()) continue;
    const cells = row.split(separator);
    for (const { key, index, factor } of found) {
      const cell = (cells[index] ?? "").replace(/"/g, "").trim();
      const value = cell === "" || /^nan$/i.test(cell) ? NaN : Number(cell);
      if (Number.isNaN(value) && cell !== "" && !/^nan$/i.test(cell)) {
        return { message: `${name}, line ${number + 2}: “${cell}” is not a number` };
      }
      recording[key].push(factor * value);
    }
  }
  const any = recording.clamp.some(Number.isFinite);
  return any ? { recording } : { message: `${name}: the file has no samples` };
}
