// Colours of the palette in use: those of the canal, and those of either side, as numbers for pictures of cells.
import { canalColours } from "../../../web/canal.js";

const NAMES = ["port", "starboard", "soft", "ink", "panel", "rule", "accent", "caution"];

export function coloursOf(element = document.documentElement) {
  const style = getComputedStyle(element);
  const named = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  return { ...canalColours(element), ...named };
}

export function numbers(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

export const mixed = (one, other, share) => one.map((value, place) => value + (other[place] - value) * share);
