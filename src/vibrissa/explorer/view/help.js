// Help on every control, and an introduction in three steps, each of which ends when a user has done it.

import { element } from "./controls.js";

/** Milliseconds that a pointer rests on a control before its help appears. */
const RESTS = 500;
/** Milliseconds from a user's action to the next step of the introduction. */
const SEEN = 900;

/** Show the help of the control under the pointer or with the focus. @param {HTMLElement} root */
export function showHelp(root) {
  const tip = element("div", { class: "help", role: "tooltip", hidden: "" });
  root.append(tip);
  for (const node of root.querySelectorAll("[data-help]")) {
    const control = node.matches("button, summary, fieldset") ? node : node.querySelector("input, select");
    control?.setAttribute("aria-description", node.getAttribute("data-help") ?? "");
  }
  let waiting = 0;
  /** @type {Element | null} */
  let pointed = null;
  const hide = () => {
    clearTimeout(waiting);
    tip.hidden = true;
    pointed = null;
  };
  /** @param {Element | null} node */
  const show = (node) => {
    if (!node) return;
    tip.textContent = node.getAttribute("data-help");
    tip.hidden = false;
    const [box, frame] = [node.getBoundingClientRect(), root.getBoundingClientRect()];
    const left = Math.min(box.left - frame.left, frame.width - tip.offsetWidth);
    tip.style.left = `${Math.max(0, left)}px`;
    tip.style.top = `${box.bottom - frame.top + 4}px`;
  };
  /** @param {Event} event */
  const helped = ({ target }) => /** @type {Element} */ (target).closest("[data-help]");
  root.addEventListener("pointerover", (event) => {
    if (event.pointerType !== "mouse" || helped(event) === pointed) return;
    hide();
    pointed = helped(event);
    waiting = setTimeout(() => show(pointed), RESTS);
  });
  root.addEventListener("pointerleave", hide);
  root.addEventListener("focusin", (event) => {
    if (/** @type {Element} */ (event.target).matches(":focus-visible")) show(helped(event));
  });
  root.addEventListener("focusout", hide);
  for (const kind of ["pointerdown", "keydown"]) root.addEventListener(kind, hide);
}

/** An introduction in steps, each of which points at a part of the page. */
export class Introduction {
  /** @param {Explorer} explorer */
  constructor(explorer) {
    this.explorer = explorer;
    this.steps = /** @type {HTMLElement[]} */ ([...explorer.at("intro").querySelectorAll("[data-at]")]);
    this.step = -1;
    this.done = -1;
    explorer.at("back").addEventListener("click", () => this.show(this.step - 1));
    explorer.at("next").addEventListener("click", () => this.show(this.step + 1));
    explorer.at("close").addEventListener("click", () => this.show(-1));
  }

  /** Go on if the user has done what the present step asks for: something at this part. @type {(part: string) => void} */
  did(part) {
    const { step } = this;
    if (this.steps[step]?.dataset.at !== part || this.explorer.at("intro").hidden || this.done === step) return;
    this.done = step;
    setTimeout(() => {
      if (this.step === step) this.show(step + 1);
    }, SEEN);
  }

  /** Show a step; past the last step, hide the introduction. @type {(step: number) => void} */
  show(step) {
    const { root } = this.explorer;
    this.step = step;
    this.done = -1;
    this.explorer.at("intro").hidden = !this.steps[step];
    this.explorer.at("back").toggleAttribute("disabled", step === 0);
    this.explorer.at("next").textContent = step === this.steps.length - 1 ? "Done" : "Next";
    for (const [i, one] of this.steps.entries()) {
      one.hidden = i !== step;
      root.querySelector(`[data-part="${one.dataset.at}"]`)?.classList.toggle("pointed", i === step);
    }
  }
}
