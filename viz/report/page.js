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

  const view = document.getElementById("view");
  try {
    window.pageView = window.beveloidView(view, JSON.parse(document.getElementById("view-data").textContent));
  } catch (error) {
    view.textContent = "The 3D view could not be started: " + error.message;
  }
})();
