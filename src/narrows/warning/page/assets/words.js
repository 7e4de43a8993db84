// Numbers as a bridge says them, each with its unit; a dash where one is not known.

export const UNKNOWN = "–";
const DEGREES = 180 / Math.PI;
const KNOT = 1852 / 3600;

const known = (value) => typeof value === "number" && Number.isFinite(value);

export function metres(value) {
  if (!known(value)) return UNKNOWN;
  return `${Math.abs(value) < 9.95 ? value.toFixed(1) : value.toFixed(0)} m`.replace("-", "−");
}

export const seconds = (value) => (known(value) ? `${value.toFixed(0)} s` : UNKNOWN);

export const knots = (value) => (known(value) ? `${(value / KNOT).toFixed(1)} kn` : UNKNOWN);

export function percent(share) {
  if (!known(share)) return UNKNOWN;
  if (share > 0 && share < 0.01) return "< 1 %";
  if (share < 1 && share > 0.99) return "> 99 %";
  return `${(100 * share).toFixed(0)} %`;
}

/** How fast a part of the hull comes nearer to a side, or goes away from it. */
export function closing(speed, side) {
  if (!known(speed)) return "";
  const nearer = side === "starboard" ? speed : -speed;
  const words = Math.abs(nearer).toFixed(1);
  return words === "0.0" ? "steady" : `${nearer > 0 ? "▼" : "▲"} ${words} m/s`;
}

/** An angle by its side: P to port, S to starboard. */
export function sided(angle) {
  if (!known(angle)) return UNKNOWN;
  const degrees = Math.round(Math.abs(angle) * DEGREES);
  return degrees ? `${angle < 0 ? "P" : "S"} ${degrees}°` : "0°";
}

export function rate(value) {
  if (!known(value)) return UNKNOWN;
  const minute = Math.abs(value) * DEGREES * 60;
  return minute < 0.05 ? "0°/min" : `${value < 0 ? "P" : "S"} ${minute.toFixed(1)}°/min`;
}

export const clock = (since1970) => new Date(1000 * since1970).toISOString().slice(11, 19) + " UTC";

export const capital = (words) => words.charAt(0).toUpperCase() + words.slice(1);
