// Day, dusk and night: chosen by hand, kept by this browser.

const KEY = "narrows-palette";

/** Calls `changed` after each change. */
export function palettes(choices, changed) {
  const usual = matchMedia("(prefers-color-scheme: dark)").matches ? "dusk" : "day";
  for (const choice of choices) {
    choice.checked = choice.value === (kept() ?? usual);
    choice.addEventListener("change", () => choose(choice.value));
  }
  choose(kept() ?? usual);

  function choose(name) {
    document.documentElement.dataset.palette = name;
    keep(name);
    changed();
  }
}

function kept() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // This browser keeps nothing.
  }
}

function keep(name) {
  try {
    localStorage.setItem(KEY, name);
  } catch {
    // As above.
  }
}
