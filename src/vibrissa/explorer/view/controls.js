// Fields that change the settings: a slider with a number beside it, and choices of words.

import { CHOICES, MOUNTING_NUMBERS, NUMBERS, ROD_NUMBERS } from "./settings.js";

/** @import { ChoiceField, NumberField, Settings } from "./settings.js" */

/**
 * @param {string} tag
 * @param {Record<string, string>} attributes
 * @param {(Node | string)[]} children
 * @returns {HTMLElement}
 */
export function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

export class Controls {
  /**
   * @param {{ fields: HTMLElement, choices: HTMLElement, mounting: HTMLElement, rod: HTMLElement }} places
   * @param {(change: Partial<Settings>) => void} changed
   */
  constructor(places, changed) {
    this.changed = changed;
    /** @type {Settings | undefined} */
    this.shown = undefined;
    /** @type {Map<string, HTMLInputElement[]>} */
    this.inputs = new Map();
    for (const field of NUMBERS) places.fields.append(this.number(field, true));
    for (const field of CHOICES) places.choices.append(this.choice(field));
    for (const field of MOUNTING_NUMBERS) places.mounting.append(this.number(field, true));
    for (const field of ROD_NUMBERS) places.rod.append(this.number(field, false));
  }

  /**
   * @param {NumberField} field
   * @param {boolean} slides
   * @returns {HTMLElement}
   */
  number({ key, symbol, label, min, max, step, unit = "" }, slides) {
    const limits = { min: String(min), max: String(max), step: String(step) };
    const box = element("input", { type: "number", id: `x-${key}`, ...limits, step: "any", inputmode: "decimal" });
    const name = element("label", { for: `x-${key}` }, element("b", {}, symbol), ` ${label}`);
    const row = element("div", { class: "field", "data-key": key }, name, box, element("small", {}, unit));
    const inputs = [/** @type {HTMLInputElement} */ (box)];
    if (slides) {
      const slider = element("input", { type: "range", ...limits, "aria-label": `${symbol}, ${label}` });
      row.append(slider);
      inputs.push(/** @type {HTMLInputElement} */ (slider));
    }
    const message = element("span", { class: "mistake", role: "alert" });
    row.append(message);
    for (const input of inputs) {
      input.addEventListener("input", () => {
        const value = Number(input.value);
        const allowed = input.value !== "" && value >= min && value <= max;
        input.setAttribute("aria-invalid", String(!allowed));
        message.textContent = allowed ? "" : `from ${min} to ${max}`;
        if (allowed) this.changed({ [key]: value });
      });
      // A number that is not allowed gives way to the one in use.
      input.addEventListener("change", () => this.settled());
    }
    this.inputs.set(key, inputs);
    return row;
  }

  /**
   * @param {ChoiceField} field
   * @returns {HTMLElement}
   */
  choice({ key, label, words }) {
    const group = element("fieldset", { class: "choice", "data-key": key }, element("legend", {}, label));
    const inputs = words.map(([word, text]) => {
      const radio = element("input", { type: "radio", name: `x-${key}`, value: word });
      radio.addEventListener("change", () => this.changed({ [key]: word }));
      group.append(element("label", {}, radio, element("span", {}, text)));
      return /** @type {HTMLInputElement} */ (radio);
    });
    this.inputs.set(key, inputs);
    return group;
  }

  /** Show the values in use, also where something else was typed. */
  settled() {
    if (this.shown) this.show(this.shown, true);
  }

  /**
   * @param {Settings} settings
   * @param {boolean} [all] Also the field in which the user types.
   */
  show(settings, all = false) {
    if (settings === this.shown && !all) return;
    this.shown = settings;
    for (const [key, inputs] of this.inputs) {
      const value = String(settings[/** @type {keyof Settings} */ (key)]);
      for (const input of inputs) {
        if (input.type === "radio") input.checked = input.value === value;
        else if (all || input !== document.activeElement || input.type === "range") input.value = value;
        if (all) input.removeAttribute("aria-invalid");
      }
      if (all) {
        const message = inputs[0].closest(".field")?.querySelector(".mistake");
        if (message) message.textContent = "";
      }
    }
  }
}
