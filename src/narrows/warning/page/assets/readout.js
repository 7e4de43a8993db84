// The numbers of an update, each into its place.

import { UNKNOWN, capital, clock, closing, knots, metres, percent, rate, seconds, sided } from "./words.js";

const RAIL = 100; // From midships to either end of the rudder's scale.
const ICONS = {
  "not available": "unknown", clear: "clear", watch: "watch", caution: "caution", warning: "warning", alarm: "alarm",
  "emergency alarm": "alarm",
};

export const icon = (level) => `#${ICONS[level] ?? "unknown"}`;

export function readout(find) {
  const write = (name, text) => {
    if (find(name).textContent !== text) find(name).textContent = text;
  };
  return (update) => {
    status(find, write, update);
    clearances(find, write, update);
    contact(write, update.forecast);
    chance(find, write, update.forecast, update.status);
    rudder(find, write, update.forecast);
    write("speed", knots(update.state.u));
    write("turn", rate(update.state.r));
    write("ship", update.ship);
    write("waterway", update.waterway);
    write("clock", clock(update.at));
  };
}

function status(find, write, { status: level, headline, caveats, alerts }) {
  document.documentElement.dataset.level = level;
  document.documentElement.toggleAttribute("data-sounding", alerts.some((alert) => alert.sounds));
  document.title = `${capital(level)} · narrows monitor`;
  find("status-icon").setAttribute("href", icon(level));
  write("word", capital(level));
  write("headline", headline);
  const other = caveats.filter((caveat) => caveat !== headline);
  find("caveats").replaceChildren(...other.map((words) => Object.assign(document.createElement("li"), { textContent: words })));
}

function clearances(find, write, { clearances: room, scene }) {
  find("nowhere").hidden = scene !== null;
  for (const end of ["bow", "stern"]) {
    for (const side of ["port", "starboard"]) {
      write(`${end}-${side}`, metres(room[end]?.[side]));
      write(`${end}-${side}-speed`, closing(room[end]?.speed, side));
    }
  }
}

function contact(write, forecast) {
  const run = forecast?.likely;
  const none = forecast ? "none in 120 s" : UNKNOWN;
  const met = run && run.contact !== null;
  write("contact", met ? seconds(run.contact) : none);
  write("contact-side", met ? `to ${run.side}` : "");
  write("nobody", percent(forecast?.nobody));
}

function chance(find, write, forecast, level) {
  const left = forecast ? (forecast.last_chance ?? Infinity) : null;
  write("chance", left === null ? UNKNOWN : left < 0 ? "none" : left === Infinity ? "> 120 s" : seconds(left));
  find("chance").dataset.urgency = forecast ? level : "unknown";
  find("chance-bar").value = Math.max(0, Math.min(left ?? 0, 120));
}

function rudder(find, write, forecast) {
  const limit = forecast?.rudder_limit ?? null;
  const place = (angle) => RAIL * Math.max(-1, Math.min(1, (angle ?? 0) / (limit ?? 1)));
  const danger = forecast && forecast.last_chance !== null;
  write("escape", danger ? forecast.escape.words : forecast ? "nothing" : UNKNOWN);
  const clear = forecast?.escape.clearance > 0 ? `: keeps ${metres(forecast.escape.clearance)} clear` : ": too late to stay clear";
  write("leaves", danger ? clear : "");
  write("rudder", sided(forecast?.rudder));
  write("limit-port", sided(limit === null ? null : -limit));
  write("limit-starboard", sided(limit));
  find("order-mark").setAttribute("transform", `translate(${place(forecast?.escape.order)})`);
  find("rudder-mark").setAttribute("transform", `translate(${place(forecast?.rudder)})`);
  find("order-mark").toggleAttribute("hidden", !danger);
  find("rudder-mark").toggleAttribute("hidden", !forecast);
}
