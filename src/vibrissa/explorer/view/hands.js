// Actions of a user: drag clamp, curve and map, press keys, drop a file, save drawings and readings.

import { asCsv, asPng, asSvg, download } from "./exports.js";
import { readRecording } from "./recording.js";

/** Distance in pixels within which the line of friction can be dragged. */
const HOLD = 14;
/** Change of friction when a key is pressed. */
const FRICTION_STEP = 0.005;
const KEYS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

/**
 * Follow a pointer that is held down; `begin` returns the function to call for each move.
 * @type {(node: SVGElement, begin: (event: PointerEvent) => (event: PointerEvent) => void) => void}
 */
function dragged(node, begin) {
  /** @type {((event: PointerEvent) => void) | null} */
  let move = null;
  node.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    move = begin(event);
    node.setPointerCapture(event.pointerId);
  });
  node.addEventListener("pointermove", (event) => move?.(event));
  node.addEventListener("lostpointercapture", () => {
    move = null;
  });
}

/**
 * Let keys move a slider by steps, or to its start.
 * @type {(node: SVGElement, by: (steps: number) => void, home?: () => void) => void}
 */
function keyed(node, by, home) {
  node.addEventListener("keydown", (event) => {
    // With these keys a browser has commands of its own.
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const steps = KEYS[/** @type {keyof typeof KEYS} */ (event.key)];
    if (!steps && !(home && event.key === "Home")) return;
    event.preventDefault();
    if (steps) by(steps);
    else home?.();
  });
}

/** Drag the clamp, or move it by keys. @param {Explorer} explorer */
export function listenToClamp(explorer) {
  const { svg, clamp } = explorer.stage;
  dragged(svg, (event) => {
    explorer.play(false);
    clamp.focus({ preventScroll: true });
    const [at, from] = [event.clientX, explorer.clampPlace];
    return ({ clientX }) => explorer.moveTo(from + (clientX - at) / explorer.stage.scale);
  });
  keyed(clamp, (steps) => explorer.moveBy(steps), () => explorer.moveTo(0));
}

/** Drag the line of friction, or the point on the sticking curve. @param {Explorer} explorer */
export function listenToCurve(explorer) {
  const { plot, sliders } = /** @type {StickingPlot} */ (explorer.plots[0]);
  /** Friction whose line is at a height of the plot. @param {number} demand */
  const frictionAt = (demand) => Math.tan(Math.atan(demand) - explorer.model.inclination);
  const friction = (/** @type {number} */ mu0) => {
    explorer.introduction.did("curve");
    explorer.change({ mu0: rounded(mu0, FRICTION_STEP, 0.02, 2) });
  };
  dragged(plot.svg, (event) => {
    explorer.play(false);
    const line = explorer.model.sticking?.ahead ?? NaN;
    const place = plot.placeOf(event);
    const isPoint = event.target === sliders.now;
    const isLine = !isPoint && Math.abs(place.y - plot.y(line)) < HOLD;
    /** @param {Point} place */
    const move = (place) => {
      const { x, y } = plot.valueAt(place);
      if (isLine) friction(frictionAt(y));
      else explorer.stickAt(x / explorer.units.scale.length);
    };
    (isLine ? sliders.handle : sliders.now).focus({ preventScroll: true });
    if (!isPoint && !isLine) move(place);
    return (event) => move(plot.placeOf(event));
  });
  keyed(sliders.handle, (steps) => friction(explorer.model.settings.mu0 + steps * FRICTION_STEP));
  keyed(sliders.now, (steps) => explorer.stickAt(explorer.model.place.x0 + steps * explorer.model.settings.dx0));
}

/** @type {(value: number, step: number, low: number, high: number) => number} */
function rounded(value, step, low, high) {
  const near = step * Math.round(Math.min(high, Math.max(low, value)) / step);
  return Number(near.toFixed(4));
}

/** Set taper and friction by a point on the map. @param {Explorer} explorer */
export function listenToMap(explorer) {
  const { plot } = /** @type {RegimePlot} */ (explorer.plots[4]);
  /** @param {PointerEvent} event */
  const choose = (event) => {
    const { x, y } = plot.valueAt(plot.placeOf(event));
    explorer.change({ theta: rounded(x, 0.01, 1, plot.frame.right), mu0: rounded(y, FRICTION_STEP, 0.02, 2) });
  };
  dragged(plot.svg, (event) => {
    choose(event);
    return choose;
  });
}

/** Read recordings, and save drawings and readings. @param {Explorer} explorer */
export function listenToFiles(explorer) {
  const { root } = explorer;
  /** @param {File | undefined} file */
  const read = async (file) => {
    if (!file) return;
    const text = await file.text().catch(() => null);
    const found = text === null ? { message: `${file.name} cannot be read` } : readRecording(file.name, text);
    const ok = "recording" in found;
    if (ok) explorer.recorded = found.recording;
    explorer.say(ok ? `${file.name} is drawn with the load on the clamp.` : `${found.message}.`);
    explorer.dirty = true;
  };
  const input = /** @type {HTMLInputElement} */ (explorer.at("file"));
  input.addEventListener("change", () => {
    read(input.files?.[0]);
    // The same file, corrected, is to be a change.
    input.value = "";
  });
  /** @param {DragEvent} event */
  const dropped = (event) => {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    // While it is dragged, the file is not yet known.
    read(event.dataTransfer.files[0]);
  };
  addEventListener("dragover", dropped);
  addEventListener("drop", dropped);
  const drawing = () => asSvg(root, explorer.summary());
  const files = {
    svg: () => new Blob([drawing().text], { type: "image/svg+xml" }),
    png: () => asPng(drawing()),
    csv: () => new Blob([asCsv(explorer.model.trace, explorer.model.settings, explorer.units)], { type: "text/csv" }),
  };
  for (const [kind, made] of Object.entries(files)) {
    explorer.at(kind).addEventListener("click", async () => {
      download(`vibrissa.${kind}`, await made());
      explorer.say(`vibrissa.${kind} is saved with your downloads.`, true);
    });
  }
}
