// The alerts, the most urgent first; acknowledged and silenced by buttons, or by the keys a and s.
// A row stays the same element while its alert lasts, so that the focus of a keyboard stays too.

import { icon } from "./readout.js";
import { capital } from "./words.js";

const KEYS = { a: "acknowledge", s: "silence" };
const WORDS = { acknowledge: "Acknowledge", silence: "Silence" };

/** `ask` sends a request; `speak` says a sentence to who does not see. */
export function alertList(find, ask, speak) {
  const rows = new Map();
  let shown = [];
  let told = new Map();

  function request(command, alert) {
    const { identifier, instance, revision } = alert;
    find("refused").textContent = "";
    ask({ command, identifier, instance, revision });
  }

  /** `above` has sentences that stand on the page already: they are not shown twice. */
  function show(alerts, above) {
    shown = alerts;
    const focused = document.activeElement?.closest("#alerts button");
    for (const [identifier, row] of rows) {
      if (!alerts.some((alert) => alert.identifier === identifier)) row.remove(), rows.delete(identifier);
    }
    alerts.forEach((alert, place) => arrange(find("alerts"), rowOf(alert, above), place));
    find("no-alerts").hidden = alerts.length > 0;
    if (focused && !focused.isConnected) next(find).focus();
    announce(alerts);
  }

  function rowOf(alert, above) {
    const row = rows.get(alert.identifier) ?? newRow(alert.identifier);
    fill(row, alert, above);
    buttons(row.querySelector(".do"), alert, request);
    return row;
  }

  function newRow(identifier) {
    const row = document.createElement("li");
    row.innerHTML =
      '<svg class="icon" aria-hidden="true"><use/></svg><p class="what"><strong></strong> <em class="state"></em> <span></span></p><p class="do"></p>';
    rows.set(identifier, row);
    return row;
  }

  function announce(alerts) {
    const news = alerts.filter((alert) => told.get(alert.identifier) !== alert.revision && alert.sounds);
    told = new Map(alerts.map((alert) => [alert.identifier, alert.revision]));
    if (news.length) speak(news.map((alert) => `${capital(alert.priority)}: ${alert.text}`).join(" "));
  }

  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const command = KEYS[event.key.toLowerCase()];
    const first = shown.find((alert) => alert.may.includes(command));
    if (first) request(command, first);
  });

  return { show };
}

function arrange(list, row, place) {
  if (list.children[place] !== row) list.insertBefore(row, list.children[place] ?? null);
}

function fill(row, alert, above) {
  row.dataset.priority = alert.priority;
  row.dataset.state = alert.state;
  row.querySelector("use").setAttribute("href", icon(alert.priority));
  row.querySelector("strong").textContent = alert.name;
  const said = row.querySelector(".what span");
  said.textContent = alert.text;
  said.className = above.includes(alert.text) ? "unseen" : "";
  row.querySelector(".state").textContent = stateOf(alert);
}

/** Nobody is asked to acknowledge a caution. */
function stateOf({ priority, state }) {
  return priority === "caution" && state === "acknowledged" ? "Caution" : `${capital(priority)}, ${state}`;
}

function buttons(place, alert, request) {
  for (const button of [...place.children]) if (!alert.may.includes(button.dataset.command)) button.remove();
  for (const command of alert.may) {
    const button = [...place.children].find((one) => one.dataset.command === command) ?? newButton(place, command);
    button.setAttribute("aria-label", `${WORDS[command]}: ${alert.name}`);
    button.onclick = () => request(command, alert);
  }
}

function newButton(place, command) {
  const button = Object.assign(document.createElement("button"), { type: "button", textContent: WORDS[command] });
  button.dataset.command = command;
  button.setAttribute("aria-keyshortcuts", Object.keys(KEYS).find((key) => KEYS[key] === command));
  return place.appendChild(button);
}

/** What to go on with at the keyboard, when the button that had the focus is gone. */
const next = (find) => find("alerts").querySelector("button") ?? find("alerts-title");
