// @ts-check
// Draws the page.

/** Light, dark, or as the system says; kept where the browser allows. */
function theme() {
  const root = document.documentElement;
  const button = part("theme");
  const dark = () => root.dataset.theme === "dark" || (!root.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches);
  button.addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    button.setAttribute("aria-label", `Switch to ${dark() ? "light" : "dark"}`);
  });
}

/** Marks the section that is being read. */
function followSections() {
  const links = new Map([...document.querySelectorAll("nav a")].map((link) => [link.getAttribute("href")?.slice(1), link]));
  const observer = new IntersectionObserver(
    (entries) => {
      for (const entry of entries)
        if (entry.isIntersecting) links.forEach((link, id) => link.classList.toggle("here", id === entry.target.id));
    },
    { rootMargin: "-20% 0px -75% 0px" },
  );
  for (const section of document.querySelectorAll("section")) if (links.has(section.id)) observer.observe(section);
}

/** Draws everything again when the width has changed. */
function followWidth() {
  let width = innerWidth;
  let asked = 0;
  addEventListener("resize", () => {
    if (innerWidth === width) return;
    width = innerWidth;
    cancelAnimationFrame(asked);
    asked = requestAnimationFrame(changed);
  });
}

/** Cards that are printed, beside the answer, the figure, the ranking and the sentences; the others are for the screen. */
const ON_PAPER = ["Compared with a baseline"];

/** Draws as wide as paper is while it is printed. */
function followPrinter() {
  const draw = (/** @type {boolean} */ onPaper) => () => {
    document.body.classList.toggle("paper", onPaper);
    for (const card of document.querySelectorAll("details.card, #origin")) {
      if (onPaper && ON_PAPER.includes(card.getAttribute("data-card") ?? "")) card.setAttribute("open", "");
      else if (onPaper) card.classList.toggle("unprinted", true);
    }
    changed();
  };
  addEventListener("beforeprint", draw(true));
  addEventListener("afterprint", draw(false));
}

function start() {
  theme();
  part("origin").toggleAttribute("open", innerWidth > NARROW);
  drawAnswer();
  drawPrograms();
  drawRanking();
  if (data.claims.length > 0) {
    drawSentences();
    drawVerdicts();
  }
  drawFilters();
  drawRatios();
  drawQueries();
  drawMisses();
  drawBands();
  drawTightness();
  drawBuilding();
  drawCosts();
  drawPeers();
  drawSweep();
  drawRecords();
  drawProvenance();
  // The machines come behind the scripts: they are large, and nobody should wait for them.
  addEventListener("DOMContentLoaded", followSections);
  followWidth();
  followPrinter();
  part("rows-close").addEventListener("click", hideRows);
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") hideRows();
  });
  addEventListener("scroll", hideTip, { passive: true });
  document.documentElement.dataset.ready = String(Math.round(performance.now()));
}

start();
