const all = (selector) => [...document.querySelectorAll(selector)];

// On a phone: the explorer is folded, and one figure is shown, chosen by its tab.
const tabs = all("[data-tab]");
const figures = all("#figures figure");
function choose(id) {
  for (const tab of tabs) tab.setAttribute("aria-pressed", String(tab.dataset.tab === id));
  for (const figure of figures) figure.classList.toggle("chosen", figure.id === id);
}
for (const tab of tabs) tab.addEventListener("click", () => choose(tab.dataset.tab));
if (tabs.length) {
  document.documentElement.classList.add("tabbed");
  choose(tabs[0].dataset.tab);
}
if (matchMedia("(max-width: 48rem)").matches) document.querySelector("#motion details").open = false;

// On a phone: the panels of a wide figure stand below each other. Each is a cutting of the picture.
const phone = matchMedia("(max-width: 31rem)");
function cut() {
  if (!phone.matches) return;
  for (const sheet of all("[data-parts]:not(.cut)")) {
    const image = sheet.querySelector("img");
    const { naturalWidth, naturalHeight } = image;
    if (!naturalWidth) {
      image.addEventListener("load", cut, { once: true });
      continue;
    }
    for (const [left, top, right, bottom] of JSON.parse(sheet.dataset.parts)) {
      const [width, height] = [right - left, bottom - top];
      const part = document.createElement("div");
      part.className = "part";
      part.style.cssText = `--share: ${width}; aspect-ratio: ${width * naturalWidth} / ${height * naturalHeight};
        background-size: ${100 / width}% ${100 / height}%;
        background-position: ${(100 * left) / (1 - width || 1)}% ${(100 * top) / (1 - height || 1)}%`;
      part.style.backgroundImage = `url(${image.src})`;
      sheet.append(part);
    }
    sheet.classList.add("cut");
  }
}
phone.addEventListener("change", cut);
cut();

// A filter shows the statements of one verdict; pressed again, it shows all statements.
const filters = all("[data-verdict]");
function filter(verdict) {
  for (const one of filters) one.setAttribute("aria-pressed", String(one.dataset.verdict === verdict));
  for (const claim of all("article[data-of]")) claim.hidden = Boolean(verdict) && claim.dataset.of !== verdict;
  const folded = document.querySelector("#settled");
  if (folded && verdict) folded.open = Boolean(folded.querySelector("article:not([hidden])"));
}
for (const one of filters) {
  one.addEventListener("click", () => filter(one.ariaPressed === "true" ? "" : one.dataset.verdict));
}

// A print shows what is folded and filtered out.
let folded = [];
addEventListener("beforeprint", () => {
  filter("");
  folded = all("details:not([open])");
  for (const one of folded) one.open = true;
});
addEventListener("afterprint", () => {
  for (const one of folded) one.open = false;
});

// A link to a statement or a figure shows it, if it is folded, filtered out or behind another tab.
function follow() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  if (target.hidden) filter("");
  if (target.matches("#figures figure")) choose(target.id);
  for (let fold = target.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", follow);
follow();
