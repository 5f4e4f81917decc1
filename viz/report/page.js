// The page's buttons, and the start of the view. Everything else on the page works without.
(function () {
  "use strict";
  const root = document.documentElement;
  const button = document.getElementById("theme");
  const asked = window.matchMedia("(prefers-color-scheme: dark)");
  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : asked.matches);
  const changed = () => {
    button.textContent = dark() ? "Light" : "Dark";
    window.dispatchEvent(new Event("themechange"));
  };
  button.addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    changed();
  });
  asked.addEventListener("change", changed);
  document.getElementById("save").addEventListener("click", () => {
    const text = document.getElementById("data").textContent;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
    link.download = `${JSON.parse(text).name.split(/[\\/]/).pop().replace(/\.toml$/i, "")}.json`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
  document.querySelector(".tools").hidden = false;
  changed();

  // The contents show where one is, and keep that in sight.
  const contents = document.querySelector("nav ul");
  const links = [...contents.querySelectorAll("a")];
  const mark = () => {
    const line = contents.getBoundingClientRect().bottom + 0.25 * window.innerHeight;
    const above = links.filter((link) => document.querySelector(link.hash).getBoundingClientRect().top <= line);
    const now = above.at(-1);
    if (now?.hasAttribute("aria-current")) return;
    for (const link of links) {
      if (link === now) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    if (now) contents.scrollLeft = now.offsetLeft + 0.5 * (now.offsetWidth - contents.clientWidth);
  };
  window.addEventListener("scroll", mark, { passive: true });
  mark();

  // A link to a folded section opens this section; printing opens all sections.
  const unfold = (fold) => {
    if (fold) fold.open = true;
  };
  const unfoldTarget = () => {
    if (location.hash) unfold(document.querySelector(`${location.hash} > details`));
  };
  for (const link of links) link.addEventListener("click", () => unfold(document.querySelector(`${link.hash} > details`)));
  window.addEventListener("hashchange", unfoldTarget);
  window.addEventListener("beforeprint", () => document.querySelectorAll("details.fold").forEach(unfold));
  unfoldTarget();

  // One pattern of each table at a time, chosen by the two errors.
  const choice = document.querySelector(".choice");
  const tables = [...document.querySelectorAll("table.cells")];
  if (tables.length) {
    const [first, second] = choice.querySelectorAll("input");
    const all = document.getElementById("all-cells");
    const choose = () => {
      const together = all.getAttribute("aria-pressed") === "true";
      for (const table of tables) {
        const rows = [...table.tBodies];
        table.classList.toggle("one", !together);
        table.querySelectorAll("td").forEach((cell) => cell.classList.remove("chosen"));
        rows[first.value].querySelectorAll("td")[second.value].classList.add("chosen");
        first.nextElementSibling.textContent = rows[first.value].querySelector("th").textContent.replace("E ", "");
        second.nextElementSibling.textContent = table.tHead.rows[0].cells[second.value].textContent.replace("Σ ", "");
      }
      for (const slider of [first, second]) {
        slider.disabled = together;
        slider.setAttribute("aria-valuetext", slider.nextElementSibling.textContent);
      }
    };
    all.addEventListener("click", () => {
      all.setAttribute("aria-pressed", String(all.getAttribute("aria-pressed") !== "true"));
      choose();
    });
    for (const slider of [first, second]) slider.addEventListener("input", choose);
    choice.hidden = false;
    choose();
  }

  const view = document.getElementById("view");
  try {
    window.pageView = window.beveloidView(view, JSON.parse(document.getElementById("view-data").textContent));
  } catch (error) {
    view.textContent = "The 3D view could not be started: " + error.message;
  }
})();
