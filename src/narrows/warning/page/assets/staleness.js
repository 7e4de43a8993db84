// Whether what is shown is old: nothing that is older than two seconds looks as if it were true.

const OLD = 2000;
const LOOK = 200;

/** Calls `changed(stale, words)` when it becomes old or fresh, and every second while it is old. */
export function staleness(changed) {
  let last = null;
  let ending = "";
  let shown = null; // Until the first look the page is as it was written: old.

  function look() {
    const age = last === null ? Infinity : performance.now() - last;
    const stale = age > OLD || ending !== "";
    const words = stale ? ending || waiting(age) : "";
    if (words === shown) return;
    shown = words;
    changed(stale, words);
  }

  setInterval(look, LOOK);
  function over(words) {
    ending = words;
    look();
  }

  return {
    fresh() {
      last = performance.now();
      over("");
    },
    over,
    /** A reason counts only while there is no update. */
    why: (words) => shown && over(words),
  };
}

function waiting(age) {
  if (age === Infinity) return "Waiting for the first one.";
  return `Since ${Math.floor(age / 1000)} s. Nothing on this page can be believed.`;
}
