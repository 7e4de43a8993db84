// What became of ships, in numbers and in sentences.
import { AFLOAT, AGROUND, room } from "./fleet_shape.js";

export const [PORT, STARBOARD, SAILS, LOST] = ["port", "starboard", "sails", "lost"];

/** How each ship of an answer ended, where [m over ground] and when [s]. */
export function outcomes({ ends }, { states }, current = 0) {
  const size = room({ states }).end;
  return Array.from({ length: ends.length / size }, (_, ship) => {
    const [at, fate] = [ship * size, ends[(ship + 1) * size - 1]];
    const time = ends[at + states];
    return { kind: kindOf(fate, ends[at + 1]), x: ends[at] + current * time, y: ends[at + 1], sine: ends[at + 3], time };
  });
}

export function kindOf(fate, y) {
  if (fate === AFLOAT) return SAILS;
  if (fate !== AGROUND) return LOST;
  return y > 0 ? STARBOARD : PORT;
}

export function tally(ended) {
  const count = (kind) => ended.filter((one) => one.kind === kind).length;
  const places = ended.filter(({ kind }) => kind === PORT || kind === STARBOARD).map(({ x }) => x).sort((a, b) => a - b);
  return {
    ships: ended.length, port: count(PORT), starboard: count(STARBOARD), sails: count(SAILS), lost: count(LOST),
    half: places.length ? places[Math.floor((places.length - 1) / 2)] : null,
  };
}

/** Which way the water turns the bow, beside which bank: first of all, and in words that need no other. */
export function turningSentence({ y, turning, steers, middle }) {
  const near = y > 0 ? STARBOARD : PORT;
  if (Math.abs(y) < middle || !turning) return "In the middle of the canal both banks pull alike: the bow stays.";
  const way = turning > 0 ? STARBOARD : PORT;
  const sense = way === near ? "towards" : "away from";
  const helm = steers ? " The helm answers with the rudder." : "";
  return `The <b class="${near}">${near}</b> bank is nearer, and turns the bow to <b class="${way}">${way}</b>, ${sense} it.${helm}`;
}

export function fleetSentence({ ships, port, starboard, sails, lost, half }, length, view) {
  const grounded = [[port, PORT], [starboard, STARBOARD]].filter(([count]) => count)
    .map(([count, side]) => `<b class="${side}">${share(count, ships)}</b> ground on the <b class="${side}">${side}</b> bank`);
  if (!grounded.length) return `Of ${ships.toLocaleString("en")} ships <b>none grounds</b> within ${view.toFixed(0)} m.`;
  const where = `, half of them within <b>${half.toPrecision(3)} m</b> (${(half / length).toFixed(1)} ship lengths)`;
  const rest = [[sails, "still sail"], [lost, "turn across the canal"]].filter(([count]) => count)
    .map(([count, what]) => `; ${share(count, ships)} ${what}`);
  return `Of ${ships.toLocaleString("en")} ships ${grounded.join(" and ")}${where}${rest.join("")}.`;
}

export function aloneSentence({ kind, x, y, time }, length) {
  if (kind === SAILS) return `The solid ship still sails after ${x.toPrecision(3)} m, ${offset(y)}.`;
  if (kind === LOST) return `The solid ship turns across the canal after ${time.toFixed(1)} s.`;
  return `The solid ship touches the ${kind} bank after ${time.toFixed(1)} s, ${x.toPrecision(3)} m on (${(x / length).toFixed(1)} ship lengths).`;
}

export const offset = (y) => `${Math.abs(y).toPrecision(2)} m to ${y > 0 ? STARBOARD : PORT} of the middle`;

function share(count, ships) {
  const percent = 100 * count / ships;
  if (count === ships) return "all";
  if (percent < 1) return "under 1 %";
  return percent > 99 ? "over 99 %" : `${Math.round(percent)} %`;
}
