// Fields that change the settings: numbers with sliders, and choices.

import { CHOICES, MOUNTING_NUMBERS, NUMBERS, numberOf, ROD_NUMBERS, WAVE_NUMBERS } from "./settings.js";

/** Most letters of names that are shown side by side; longer names are shown in a list. */
const SHORT_WORD = 10;

/** @type {(tag: string, attributes: Record<string, string>, ...children: (Node | string)[]) => HTMLElement} */
export function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

export class Controls {
  /**
   * @param {Record<"fields" | "choices" | "mounting" | "wave" | "rod", HTMLElement>} places
   * @param {(change: Partial<Settings>) => void} changed
   */
  constructor(places, changed) {
    this.changed = changed;
    /** @type {Settings | undefined} */
    this.shown = undefined;
    /** @type {Map<string, (value: string, anew: boolean) => void>} */
    this.fields = new Map();
    for (const field of NUMBERS) places.fields.append(this.number(field, true));
    for (const field of CHOICES) places.choices.append(this.choice(field));
    for (const field of MOUNTING_NUMBERS) places.mounting.append(this.number(field, true));
    for (const field of WAVE_NUMBERS) places.wave.append(this.number(field, true));
    for (const field of ROD_NUMBERS) places.rod.append(this.number(field, false));
  }

  /** @type {(field: NumberField, slides: boolean) => HTMLElement} */
  number(field, slides) {
    const { key, symbol, label, min, max, step, unit = "", help } = field;
    const [id, wrong] = [`x-${key}`, `x-${key}-mistake`];
    // A field of the type "number" would hide a text that is not a number.
    const box = /** @type {HTMLInputElement} */ (
      element("input", { type: "text", id, inputmode: "decimal", autocomplete: "off", "aria-describedby": wrong })
    );
    const name = element("label", { for: id }, element("b", {}, symbol), ` ${label}`);
    const message = element("span", { class: "mistake", id: wrong });
    const row = element("div", { class: "field", "data-key": key, "data-help": help }, name, box, element("small", {}, unit));
    const limits = { min: String(min), max: String(max), step: String(step) };
    const slider = /** @type {HTMLInputElement} */ (
      element("input", { type: "range", ...limits, "aria-label": `${symbol}, ${label}` })
    );
    row.append(...(slides ? [slider, message] : [message]));
    /** @param {string} mistake */
    const judge = (mistake) => {
      box.setAttribute("aria-invalid", String(mistake !== ""));
      message.textContent = mistake;
    };
    // The typed text stays as it is; its value is used as soon as it is allowed.
    box.addEventListener("input", () => {
      const { value, mistake } = numberOf(box.value, field);
      judge(mistake);
      if (!mistake) this.changed({ [key]: value });
    });
    slider.addEventListener("input", () => this.changed({ [key]: Number(slider.value) }));
    let used = "";
    this.fields.set(key, (value, anew) => {
      slider.value = value;
      const typed = value === used || Number(value) === numberOf(box.value, field).value;
      used = value;
      if (typed && !anew) return;
      box.value = value;
      judge("");
    });
    return row;
  }

  /** @type {(field: ChoiceField) => HTMLElement} */
  choice(field) {
    const { key, label, words, help } = field;
    if (words.some(([, text]) => text.length > SHORT_WORD)) return this.list(field);
    const group = element("fieldset", { class: "choice", "data-key": key, "data-help": help }, element("legend", {}, label));
    const radios = words.map(([word, text]) => {
      const radio = /** @type {HTMLInputElement} */ (
        element("input", { type: "radio", name: `x-${key}`, value: word })
      );
      radio.addEventListener("change", () => this.changed({ [key]: word }));
      group.append(element("label", {}, radio, element("span", {}, text)));
      return radio;
    });
    this.fields.set(key, (value) => {
      for (const radio of radios) radio.checked = radio.value === value;
    });
    return group;
  }

  /** @type {(field: ChoiceField) => HTMLElement} */
  list({ key, label, words, help }) {
    const options = words.map(([word, text]) => element("option", { value: word }, text));
    const select = /** @type {HTMLSelectElement} */ (element("select", {}, ...options));
    select.addEventListener("change", () => this.changed({ [key]: select.value }));
    this.fields.set(key, (value) => {
      select.value = value;
    });
    return element("label", { class: "choice", "data-key": key, "data-help": help }, element("span", {}, label), select);
  }

  /** Show the values in use; `anew` replaces typed texts. @type {(settings: Settings, anew?: boolean) => void} */
  show(settings, anew = false) {
    if (settings === this.shown && !anew) return;
    this.shown = settings;
    for (const [key, show] of this.fields) show(String(settings[/** @type {keyof Settings} */ (key)]), anew);
  }
}
