// What screen readers and keyboards need, and the theme does not have.
document.addEventListener("DOMContentLoaded", () => {
  const all = (selector) => document.querySelectorAll(selector);
  for (const one of all("aside.sidebar-drawer")) one.setAttribute("aria-label", "Pages");
  for (const one of all("aside.toc-drawer")) one.setAttribute("aria-label", "On this page");
  // Long lines scroll: by the keyboard, too.
  for (const one of all("pre, .equation, .table-wrapper")) one.tabIndex = 0;
  // The corner of a table is no heading.
  for (const one of all("th:empty")) one.replaceWith(document.createElement("td"));
  if (!document.querySelector("h1")) {
    const heading = document.createElement("h1");
    heading.textContent = document.title.split(" - ")[0];
    document.querySelector("[role=main], main, article")?.prepend(heading);
  }
});
