// Exports: the page's drawings as SVG or PNG, its readings as CSV.

import { COLUMNS } from "./recording.js";
import { lawOf, MOUNTING_NUMBERS, NUMBERS, ROD_NUMBERS, WAVE_NUMBERS, waveOf } from "./settings.js";
import { drawn, set, withoutNoise } from "./svg.js";
import { NONDIMENSIONAL, plainName } from "./units.js";

const STYLES = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-opacity", "fill-opacity", "font-size", "font-weight",
  "text-anchor", "opacity", "visibility", "paint-order",
];
/** Pixels between the parts of a drawing, of the height of a line of text, and of the width of a letter. */
const AROUND = 24;
const LINE = 18;
const LETTER = 6.6;
/** Digits of the readings: more would be rounding errors. */
const DIGITS = 10;

/** @type {[keyof Reading, string, Quantity][]} */
const READINGS = [
  ...COLUMNS,
  ["contact", "contact", "length"],
  ["x0", "x0", "length"],
  ["phi1", "phi1", "angle"],
  ["sc", "s_c", "number"],
];

/** Hand a file to the user. @type {(name: string, content: Blob) => void} */
export function download(name, content) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/**
 * Join the drawings of all cards to one, in two columns below a title.
 * @type {(root: Element, title: string) => Drawing}
 */
export function asSvg(root, title) {
  const cards = [...root.querySelectorAll("[data-card]")];
  const column = Math.max(...cards.map((card) => card.getBoundingClientRect().width));
  const width = Math.ceil(2 * column + 3 * AROUND);
  const whole = drawn(document.createElement("div"), "svg", { "font-family": "system-ui, sans-serif" });
  const style = getComputedStyle(root);
  const back = drawn(whole, "rect", { width, fill: style.getPropertyValue("--page").trim() });
  let top = AROUND;
  for (const line of wrapped(title, (width - 2 * AROUND) / LETTER)) {
    top += LINE;
    drawn(whole, "text", { x: AROUND, y: top, "font-size": 13, fill: style.color }).textContent = line;
  }
  const ends = [top + AROUND, top + AROUND];
  for (const card of cards) {
    const at = ends[0] <= ends[1] ? 0 : 1;
    copied(card, drawn(whole, "g", { transform: `translate(${AROUND + at * (column + AROUND)} ${ends[at]})` }));
    ends[at] += card.getBoundingClientRect().height + AROUND;
  }
  const height = Math.ceil(Math.max(...ends));
  set(whole, { xmlns: "http://www.w3.org/2000/svg", width, height, viewBox: `0 0 ${width} ${height}` });
  set(back, { height });
  return { text: new XMLSerializer().serializeToString(whole), width, height };
}

/** Break a text into lines of at most `most` letters. @type {(text: string, most: number) => string[]} */
function wrapped(text, most) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const last = lines.length - 1;
    if (lines[last] && lines[last].length + word.length > most) lines.push(word);
    else lines[last] = `${lines[last]} ${word}`.trim();
  }
  return lines;
}

/** Copy the drawings and captions of a card, with their styles. @type {(card: Element, to: Element) => void} */
function copied(card, to) {
  const box = card.getBoundingClientRect();
  for (const svg of card.querySelectorAll("svg")) {
    const { left, top, width, height } = svg.getBoundingClientRect();
    if (width === 0) continue; // hidden
    const copy = /** @type {SVGSVGElement} */ (svg.cloneNode(true));
    set(copy, { x: left - box.left, y: top - box.top, width, height });
    const nodes = copy.querySelectorAll("*");
    svg.querySelectorAll("*").forEach((node, i) => {
      const style = getComputedStyle(node);
      for (const name of STYLES) nodes[i].setAttribute(name, style.getPropertyValue(name));
    });
    to.append(copy);
  }
  for (const title of card.querySelectorAll("[data-title]")) {
    const { left, bottom, width } = title.getBoundingClientRect();
    if (width === 0) continue;
    const fill = getComputedStyle(title).color;
    const text = drawn(to, "text", { x: left - box.left, y: bottom - box.top - 5, "font-size": 13, fill });
    text.textContent = (title.textContent ?? "").replace(/\s+/g, " ").trim();
  }
}

/** A drawing as PNG, at twice its size. @type {(drawing: Drawing) => Promise<Blob>} */
export async function asPng({ text, width, height }) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * width, 2 * height];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done, fail) =>
    canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("no picture was made")))),
  );
}

/**
 * Readings as the commands write them, with the parameters in columns of their own.
 * @type {(trace: Reading[], settings: Settings, units: Units) => string}
 */
export function asCsv(trace, settings, { scale, name }) {
  const wave = waveOf(settings) ? WAVE_NUMBERS : [];
  const fields = [...NUMBERS, ...MOUNTING_NUMBERS, ...wave, ...(settings.units === "si" ? ROD_NUMBERS : [])];
  const given = [...fields.map(({ key }) => settings[key]), settings.contact, settings.section, lawOf(settings)];
  const names = fields.map(({ key, unit = "1" }) => `${key} [${plainName(unit)}]`);
  const titles = READINGS.map(([, title, quantity]) => {
    const unit = plainName(quantity === "number" ? NONDIMENSIONAL.name.length : name[quantity]);
    return `${title} [${unit}]`;
  });
  const lines = trace.map((row) => {
    const values = READINGS.map(([key, , quantity]) => {
      const value = withoutNoise(Number(row[key])) * scale[quantity];
      return Number(value.toPrecision(DIGITS));
    });
    return [...values, ...given].join(",");
  });
  return `${[[...titles, ...names, "contact_model", "section", "law"].join(","), ...lines].join("\n")}\n`;
}
