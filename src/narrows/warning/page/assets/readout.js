// The numbers of an update, each into its place.

import { UNKNOWN, capital, clock, knots, metres, percent, rate, seconds, sided } from "./words.js";

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
    chance(find, write, update.forecast?.likely);
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
  write("port", metres(room.port));
  write("starboard", metres(room.starboard));
}

function contact(write, forecast) {
  const run = forecast?.likely;
  const none = forecast ? "none in 120 s" : UNKNOWN;
  const met = run && run.contact !== null;
  write("contact", met ? seconds(run.contact) : none);
  write("contact-side", met ? `to ${run.side}` : "");
  const [asItIs, pilot] = [forecast?.cases["as it is"], forecast?.cases["pilot now"]];
  write("soon", percent(asItIs?.soon));
  write("pilot", percent(pilot?.probability));
  write("pilot-side", pilot?.side ? `to ${pilot.side}` : "");
}

function chance(find, write, run) {
  const left = run && !run.gone ? (run.last_chance ?? Infinity) : 0;
  const words = left === Infinity ? "> 60 s" : seconds(left);
  write("chance", run ? (run.gone ? "gone" : words) : UNKNOWN);
  find("chance").dataset.urgency = urgency(run, left);
  find("chance-bar").value = Math.min(left, 60);
}

function urgency(run, left) {
  if (!run) return "unknown";
  return left <= 20 ? "alarm" : left <= 40 ? "warning" : "";
}

function rudder(find, write, forecast) {
  const limit = forecast?.rudder_limit ?? null;
  const place = (angle) => RAIL * Math.max(-1, Math.min(1, (angle ?? 0) / (limit ?? 1)));
  const needed = forecast?.rudder_needed ?? null;
  const most = sided(limit).replace("S ", "");
  write("needed", !forecast ? UNKNOWN : needed === null ? `more than ${most}` : `${sided(needed)} of ${most}`);
  find("needed").dataset.urgency = forecast && needed === null ? "alarm" : "";
  write("rudder", sided(forecast?.rudder));
  write("limit-port", sided(limit === null ? null : -limit));
  write("limit-starboard", sided(limit));
  find("needed-mark").setAttribute("transform", `translate(${place(needed)})`);
  find("rudder-mark").setAttribute("transform", `translate(${place(forecast?.rudder)})`);
  find("span").setAttribute("d", `M0 0H${place(needed)}`);
  find("needed-mark").toggleAttribute("hidden", needed === null);
  find("rudder-mark").toggleAttribute("hidden", !forecast);
}
