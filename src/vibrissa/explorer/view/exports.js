// What a user takes along: the page's drawings as SVG or PNG, its readings as CSV.

import { drawn, set } from "./svg.js";

const STYLES = ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-opacity", "fill-opacity", "font-size", "text-anchor", "opacity"];
const AROUND = 24;

/**
 * Hand a file to the user.
 *
 * @param {string} name
 * @param {Blob} content
 */
export function download(name, content) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/**
 * Put drawings into one, where they are on the page, with the styles that they have there.
 *
 * @param {Element} root Of which the drawings are parts.
 * @returns {{ text: string, width: number, height: number }}
 */
export function asSvg(root) {
  const box = root.getBoundingClientRect();
  const [width, height] = [Math.ceil(box.width) + 2 * AROUND, Math.ceil(box.height) + 2 * AROUND];
  const whole = drawn(document.createElement("div"), "svg", {
    xmlns: "http://www.w3.org/2000/svg",
    width,
    height,
    viewBox: `0 0 ${width} ${height}`,
    "font-family": "system-ui, sans-serif",
  });
  const page = getComputedStyle(root).getPropertyValue("--page").trim();
  drawn(whole, "rect", { width, height, fill: page });
  for (const svg of root.querySelectorAll("svg")) {
    const place = svg.getBoundingClientRect();
    const copy = /** @type {SVGSVGElement} */ (svg.cloneNode(true));
    set(copy, {
      x: place.left - box.left + AROUND,
      y: place.top - box.top + AROUND,
      width: place.width,
      height: place.height,
    });
    styled(svg, copy);
    whole.append(copy);
  }
  for (const title of root.querySelectorAll("[data-title]")) {
    const place = title.getBoundingClientRect();
    const text = drawn(whole, "text", {
      x: place.left - box.left + AROUND,
      y: place.bottom - box.top + AROUND - 4,
      "font-size": 13,
      fill: getComputedStyle(title).color,
    });
    text.textContent = (title.textContent ?? "").replace(/\s+/g, " ").trim();
  }
  return { text: new XMLSerializer().serializeToString(whole), width, height };
}

/**
 * @param {Element} from
 * @param {Element} to
 */
function styled(from, to) {
  const nodes = to.querySelectorAll("*");
  from.querySelectorAll("*").forEach((node, i) => {
    const style = getComputedStyle(node);
    for (const name of STYLES) nodes[i].setAttribute(name, style.getPropertyValue(name));
  });
}

/**
 * @param {{ text: string, width: number, height: number }} drawing
 * @returns {Promise<Blob>} A PNG of twice the size.
 */
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
 * @param {Record<string, number | string>[]} rows
 * @returns {string}
 */
export function asCsv(rows) {
  const names = Object.keys(rows[0] ?? {});
  const lines = rows.map((row) => names.map((name) => row[name]).join(","));
  return `${[names.join(","), ...lines].join("\n")}\n`;
}
