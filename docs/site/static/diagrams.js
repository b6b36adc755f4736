/** Draws the diagrams of a page in the colours of the page. */
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
const chosen = document.body.dataset.theme;
mermaid.initialize({
  startOnLoad: false,
  securityLevel: "strict",
  theme: chosen === "dark" || (chosen === "auto" && dark) ? "dark" : "neutral",
});
mermaid.run({ querySelector: "pre.mermaid" });
