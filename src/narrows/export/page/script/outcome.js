// What became of ships, in numbers and in sentences.
import { AFLOAT, AGROUND, rowLengths } from "./fleet_shape.js";

/** A length in words: three digits, as 1,110 m or 13.7 m. */
export const metres = (x) => `${x.toLocaleString("en", { maximumSignificantDigits: 3 })} m`;

export const [PORT, STARBOARD, SAILS, LOST] = ["port", "starboard", "sails", "lost"];

/** How each ship of an answer ended, where [m over ground] and when [s]. */
export function outcomes({ ends }, { states }, current = 0) {
  const size = rowLengths({ states }).end;
  return Array.from({ length: ends.length / size }, (_, ship) => {
    const [at, outcome] = [ship * size, ends[(ship + 1) * size - 1]];
    const time = ends[at + states];
    return { kind: kindOf(outcome, ends[at + 1]), x: ends[at] + current * time, y: ends[at + 1], sine: ends[at + 3], time };
  });
}

export function kindOf(outcome, y) {
  if (outcome === AFLOAT) return SAILS;
  if (outcome !== AGROUND) return LOST;
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

const SURE = 0.95;
const TOLD = 0.05; // least share of ships that a sentence is worth
const NO_BANK = "This model has no bank force: the ship sails as in open water, until it touches a bank.";
const OPEN = "This model has no bank force: the ship sails in open water.";
const MIDDLE = "In the middle of the canal both banks pull alike: the bow stays.";

const DOUBTS = {
  tests: ["the tests do not settle this", "that the tests allow"],
  estimate: ["this ship was not tested", "that the estimate allows"],
  assumed: ["how well its tests determine this is not known", "of the assumed spread"],
};

export const isSure = ({ settled, agree }) => settled && agree >= SURE;

/** The side to which a yaw acceleration turns the bow. */
export const sideOf = (turning) => (turning > 0 ? STARBOARD : PORT);

/**
 * Which way the water turns the bow, beside which bank, and how sure that is; `agree` is the share of ships that turn so,
 * `basis` where the spread of the coefficients comes from.
 */
export function turningSentence({ y, turning, steers, middle, banks, open, settled, basis, agree }) {
  if (!banks) return open ? OPEN : NO_BANK;
  if (Math.abs(y) < middle || !turning) return MIDDLE;
  const near = y > 0 ? STARBOARD : PORT;
  const [way, other] = [sideOf(turning), sideOf(-turning)];
  const nearer = `At the start the <b class="${near}">${near}</b> bank is nearer`;
  const helm = steers ? " The helm answers with the rudder." : "";
  const turns = `the bow to <b class="${way}">${way}</b>, ${way === near ? "towards" : "away from"} it`;
  if (isSure({ settled, agree })) return `${nearer}, and turns ${turns}.${helm}`;
  const [doubt, spread] = DOUBTS[basis];
  const against = agree < 1 ? ` ${share(1 - agree, 1)} of the ships ${spread} turn to ${other}.` : "";
  return `${nearer}. It may turn ${turns}, but ${doubt}.${against}${helm}`;
}

/** From when on a voyage is farther off the middle, or more across the canal, than the tests were [s]; nothing where it is not. */
export function leaves(path, { y, psi }, seconds, tests) {
  const first = (limit, size) => (limit ? path.findIndex((point) => size(point) > limit) : -1);
  const places = [first(y?.[1], ([, offset]) => Math.abs(offset)), first(psi?.[1], ([, , sine]) => Math.asin(Math.abs(sine)))];
  const words = ["farther off the middle", "more across the canal"];
  return places.flatMap((place, kind) => (place < 0 ? [] : [`From ${(place * seconds).toFixed(1)} s on the ship is ${words[kind]} than in ${tests}.`]));
}

/** What becomes of the ships; `back` is the share of those aground that lies on the other side than that of its first turn. */
export function fleetSentence({ ships, port, starboard, sails, lost, half }, { length, view, open, back }) {
  const parts = shares([port, starboard, sails, lost], ships);
  const grounded = [[port, PORT, parts[0]], [starboard, STARBOARD, parts[1]]].filter(([count]) => count)
    .map(([, side, part]) => `<b class="${side}">${part}</b> ground on the <b class="${side}">${side}</b> bank`);
  if (open && !lost) return `All ${ships.toLocaleString("en")} ships still sail after ${metres(view)}.`;
  if (open) return `Of ${ships.toLocaleString("en")} ships ${share(lost, ships)} turn by more than 90°.`;
  if (!grounded.length) return `Of ${ships.toLocaleString("en")} ships <b>none grounds</b> within ${metres(view)}.`;
  const where = `, half of them within <b>${metres(half)}</b> (${(half / length).toFixed(1)} ship lengths)`;
  const rest = [[sails, "still sail", parts[2]], [lost, "turn across the canal", parts[3]]].filter(([count]) => count)
    .map(([, what, part]) => `; ${part} ${what}`);
  const turned = back < TOLD ? "" : ` Of those that ground, ${share(back, 1)} come back from their first turn.`;
  return `Of ${ships.toLocaleString("en")} ships ${grounded.join(" and ")}${where}${rest.join("")}.${turned}`;
}

export function aloneSentence({ kind, x, y, time }, { length, open, turned }) {
  if (kind === SAILS) return `The solid ship still sails at the end, ${offset(y, open)}.`;
  if (kind === LOST) return `The solid ship turns ${open ? "by 90°" : "across the canal"} after ${time.toFixed(1)} s.`;
  const way = turned && turned !== kind ? "comes back from its first turn and touches" : "touches";
  return `The solid ship ${way} the ${kind} bank after ${time.toFixed(1)} s, ${metres(x)} on (${(x / length).toFixed(1)} ship lengths).`;
}

export function offset(y, open) {
  const side = y > 0 ? STARBOARD : PORT;
  return `${Math.abs(y).toLocaleString("en", { maximumSignificantDigits: 2 })} m to ${side} of the ${open ? "dashed line" : "middle"}`;
}

/** Counts of all ships in words, in whole percent that add up to 100 (largest remainders). */
export function shares(counts, ships) {
  const exact = counts.map((count) => 100 * count / ships);
  const whole = exact.map(Math.floor);
  const order = counts.map((_, place) => place).sort((a, b) => exact[b] - whole[b] - (exact[a] - whole[a]));
  for (const place of order.slice(0, 100 - whole.reduce((sum, one) => sum + one, 0))) whole[place] += 1;
  return counts.map((count, place) => {
    if (count === ships) return "all";
    if (whole[place] === 0) return "under 1\u00a0%";
    return whole[place] === 100 ? "over 99\u00a0%" : `${whole[place]}\u00a0%`;
  });
}

const share = (count, ships) => shares([count, ships - count], ships)[0];
