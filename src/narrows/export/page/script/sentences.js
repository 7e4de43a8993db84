// The words of the page: a headline, what the ship does, what to doubt, and the same for those who hear the page.
import { aloneSentence, fleetSentence, isSure, leaves, offset, sideOf, tally, turningSentence } from "./outcome.js";
import { beyond } from "./settings.js";

const MIDDLE = 1e-3;
const SINGLE = "The maps show the solid ship alone. Other ships of the picture above may turn the other way.";

export function said(at, data, now, view) {
  const { values, start, alone, ended, first } = now;
  const turning = now.turning(first);
  const middle = MIDDLE * values.width;
  const { banks, settled, basis, open } = data;
  const turns = banks && turning && Math.abs(start.y) >= middle;
  written(at.turning, turningSentence({ y: start.y, turning, steers: values.helm > 0, middle, banks, open, settled, basis, agree: now.agree }));
  const computing = `Computing ${values.ships.toLocaleString("en")} ships ...`;
  written(at.fleet, !ended.length ? computing : fleetSentence(tally(ended), { length: data.ship.length, view, open, back: turns ? now.back : 0 }));
  written(at.alone, aloneSentence(alone, { length: data.ship.length, open, turned: turns && sideOf(turning) }));
  written(at.single, !banks || isSure({ settled, agree: now.agree }) ? "" : SINGLE);
  written(at.water, open ? "open water" : canalWords(values));
  listed(at.caveats, caveats(data, now));
  at.canal.setAttribute("aria-label", `The ships from above. ${at.turning.textContent} ${at.fleet.textContent}`);
  at.map.setAttribute("aria-valuetext", `start ${offset(start.y, open)}, ${values.u} m/s; ${at.alone.textContent}`);
}

/** What stands beside the headline: what the model says of itself, then what is beyond its data, assumed or moved. */
function caveats(data, { values, start, path, seconds }) {
  const out = beyond(data, values).map(({ label, told, beyond: range }) => `${told ?? label} (${range})`);
  const moved = start.moved ? [`There is no room for that: the ship starts ${offset(start.y, data.open)}.`] : [];
  const assumed = data.assumed && values.doubt > 0 ? [`The spread of the ships is assumed: each coefficient ± ${(100 * values.doubt * data.share).toFixed(0)} %.`] : [];
  const gone = leaves(path, data.tested, seconds, data.basis === "estimate" ? "tests of other ships" : "the tests");
  return [...moved, ...assumed, ...data.notes, ...gone, ...(out.length ? [`Beyond the data: ${out.join("; ")}.`] : [])];
}

function canalWords({ width, depth }) {
  const exact = (metres) => `${metres.toLocaleString("en", { maximumSignificantDigits: 4 })} m`;
  const deep = depth ? `${exact(depth)} deep` : "of unknown depth";
  return `a canal ${exact(width)} wide, ${deep}`;
}

function written(element, html) {
  if (element.innerHTML !== html) element.innerHTML = html;
}

function listed(element, sentences) {
  const items = sentences.map((text) => Object.assign(document.createElement("li"), { textContent: `${text} ` }));
  element.replaceChildren(...items);
}
