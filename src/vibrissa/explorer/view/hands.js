// What a user's hands do: drag the clamp, point at the map, drop a file, take the drawings along.

import { asPng, asSvg, download } from "./exports.js";
import { readRecording } from "./recording.js";

/** @import { Explorer } from "./explorer.js" */
/** @import { RegimePlot } from "./panels.js" */

/**
 * Drag the clamp, or move it by keys.
 *
 * @param {Explorer} explorer
 */
export function listenToClamp(explorer) {
  const { svg, clamp } = explorer.stage;
  /** @type {{ at: number, clamp: number } | null} */
  let held = null;
  svg.addEventListener("pointerdown", (event) => {
    explorer.play(false);
    held = { at: event.clientX, clamp: explorer.clampPlace };
    svg.setPointerCapture(event.pointerId);
    clamp.focus({ preventScroll: true });
  });
  svg.addEventListener("pointermove", (event) => {
    if (held) explorer.moveTo(held.clamp + (event.clientX - held.at) / explorer.stage.scale);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    svg.addEventListener(end, () => {
      held = null;
    });
  }
  clamp.addEventListener("keydown", (event) => {
    const { dx0 } = explorer.model.settings;
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };
    const steps = way[/** @type {keyof typeof way} */ (event.key)];
    if (!steps && event.key !== "Home") return;
    event.preventDefault();
    explorer.play(false);
    const from = Number.isNaN(explorer.clampAim) ? explorer.clampPlace : explorer.clampAim;
    explorer.moveTo(event.key === "Home" ? 0 : from + steps * dx0);
  });
}

/**
 * On the map, a point chooses taper and friction.
 *
 * @param {Explorer} explorer
 */
export function listenToMap(explorer) {
  const svg = explorer.graphic("regimes");
  const plot = /** @type {RegimePlot} */ (explorer.plots[4]).plot;
  /** @param {PointerEvent} event */
  const choose = (event) => {
    const box = svg.getBoundingClientRect();
    const { x, y } = plot.valueAt(event.clientX - box.left, event.clientY - box.top);
    explorer.change({
      theta: Math.round(100 * Math.min(plot.frame.right, Math.max(1, x))) / 100,
      mu0: Math.round(200 * Math.min(2, Math.max(0.02, y))) / 200,
    });
  };
  svg.addEventListener("pointerdown", (event) => {
    svg.setPointerCapture(event.pointerId);
    choose(event);
  });
  svg.addEventListener("pointermove", (event) => event.buttons && choose(event));
}

/**
 * Take recordings, and hand out what is seen.
 *
 * @param {Explorer} explorer
 */
export function listenToFiles(explorer) {
  /** @param {File | undefined} file */
  const read = async (file) => {
    if (!file) return;
    const { modulus, diameter, length } = explorer.model.settings;
    const found = readRecording(file.name, await file.text(), { modulus, diameter, length });
    const ok = "recording" in found;
    explorer.recording = ok ? found.recording : explorer.recording;
    explorer.say(ok ? `${file.name} is drawn with the clamp’s forces.` : found.message);
    explorer.dirty = true;
  };
  const input = /** @type {HTMLInputElement} */ (explorer.at("file"));
  input.addEventListener("change", () => read(input.files?.[0]));
  explorer.root.addEventListener("dragover", (event) => {
    event.preventDefault();
    explorer.root.classList.add("dropping");
  });
  explorer.root.addEventListener("dragleave", () => explorer.root.classList.remove("dropping"));
  explorer.root.addEventListener("drop", (event) => {
    event.preventDefault();
    explorer.root.classList.remove("dropping");
    read(event.dataTransfer?.files[0]);
  });
  const drawings = explorer.at("drawings");
  explorer.at("svg").addEventListener("click", () =>
    download("vibrissa.svg", new Blob([asSvg(drawings).text], { type: "image/svg+xml" })),
  );
  explorer.at("png").addEventListener("click", async () =>
    download("vibrissa.png", await asPng(asSvg(drawings))),
  );
  explorer.at("csv").addEventListener("click", () =>
    download("vibrissa.csv", new Blob([explorer.readings()], { type: "text/csv" })),
  );
}
