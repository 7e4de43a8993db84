// The canal about the ship: ahead is up, the canal stays where it is, the ship moves across it.

import { canalColours, canalView } from "./canal.js";

const DOWN = 0.76; // Of the height, where midship is.
const [SECONDS_AHEAD, HULL_AHEAD, LEAST_AHEAD] = [120, 0.8, 2.2]; // Seconds of way, and lengths, ahead of midship.
const [ROOM, EVEN] = [1.25, 100]; // Widths of the canal across; and metres by which the scale changes, not more often.
const HULLS_EVERY = 6; // Of the times of a track.

export function drawing(canvas) {
  const colours = {};
  const view = canalView(canvas, colours);
  let last = null;

  function recolour() {
    const style = getComputedStyle(canvas);
    Object.assign(colours, canalColours(canvas), { alarm: style.getPropertyValue("--alarm").trim() });
    again();
  }

  function again() {
    if (last) draw(last);
  }

  function draw(update) {
    last = update;
    const scene = update.scene;
    if (!scene) return view.look({});
    view.look(camera(canvas, scene, update.state.u));
    view.water(scene.banks);
    for (const limit of scene.limits) view.track(limit, { stroke: "bank", width: 1.5, dash: [6, 6] });
    if (scene.fan) drawForecast(view, scene, update.forecast);
    view.ship(pose(scene.ship.pose), scene.ship);
    return view.scaleBar();
  }

  new ResizeObserver(again).observe(canvas);
  return { draw, recolour };
}

function camera(canvas, { ship, middle, banks }, speed) {
  const [along, across, heading] = middle;
  const width = even(widest(banks));
  const ahead = even(Math.max(SECONDS_AHEAD * speed + HULL_AHEAD * ship.length, LEAST_AHEAD * ship.length));
  const high = ahead / (DOWN * canvas.clientHeight);
  const wide = (ROOM * width) / canvas.clientWidth;
  return { along, across, heading, right: 0.5, down: DOWN, metresPerPixel: Math.max(high, wide) };
}

const even = (metres) => EVEN * Math.ceil(metres / EVEN);

function widest([port, starboard]) {
  return Math.max(...port.map(([north, east], place) => Math.hypot(starboard[place][0] - north, starboard[place][1] - east)));
}

function drawForecast(view, { ship, fan }, forecast) {
  const contact = forecast.likely.contact ?? Infinity;
  view.fan(fan.members, { stroke: "fan", width: 4, opacity: 0.13 });
  view.track([place(ship.pose), ...fan.escape.map(place)], { stroke: "track", width: 2.5, dash: [2, 7] });
  view.track([place(ship.pose), ...fan.likely.map(place)], { stroke: "fan", width: 2.5 });
  fan.likely.forEach((at, number) => {
    const met = contact <= fan.times[number];
    if ((number + 1) % HULLS_EVERY && !met) return;
    view.ship(pose(at), ship, { stroke: met ? "alarm" : "fan", width: met ? 2.5 : 1.5 });
  });
}

const place = ([north, east]) => [north, east];
const pose = ([along, across, heading]) => ({ along, across, heading });
