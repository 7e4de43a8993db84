// The map: how far a ship gets from every start and at every speed, in the colour of the bank that it meets.
import { chart } from "./chart.js";
import { mixed, numbers } from "./colours.js";
import { PORT, SAILS, STARBOARD } from "./outcome.js";

const FINE = 100;
const FAINTEST = 0.16;

export function mapCells({ cells, ended }, across, colours, view, length) {
  const pixels = new Uint8ClampedArray(4 * across * across);
  const lengths = new Int32Array(across * across);
  const [land, water, sides] = [numbers(colours.land), numbers(colours.panel), { [PORT]: numbers(colours.port), [STARBOARD]: numbers(colours.starboard) }];
  for (let cell = 0; cell < across * across; cell += 1) pixels.set([...land, 255], 4 * cell);
  cells.forEach((cell, place) => {
    const { kind, x } = ended[place];
    const near = 1 - Math.min(1, Math.max(0, x / view));
    const colour = sides[kind] ? mixed(water, sides[kind], FAINTEST + (1 - FAINTEST) * near) : water;
    pixels.set(colour, 4 * cell);
    lengths[cell] = kind === SAILS ? -1 : 1 + Math.floor(x / length);
  });
  if (across >= FINE) contours(pixels, lengths, across, numbers(colours.ink));
  return pixels;
}

/** A faint line at every ship length. */
function contours(pixels, lengths, across, ink) {
  for (let cell = across + 1; cell < lengths.length; cell += 1) {
    const here = lengths[cell];
    const crossed = [lengths[cell - 1], lengths[cell - across]].some((other) => other && other !== here);
    if (here && crossed && cell % across) pixels.set(mixed([...pixels.subarray(4 * cell, 4 * cell + 3)], ink, 0.22), 4 * cell);
  }
}

export function drawMap(canvas, height, picture, { values, start, speeds, tested, colours }) {
  const plot = chart(canvas, height, { range: speeds, label: "speed, m/s" }, values.width, colours);
  plot.cells(picture.pixels, picture.across, picture.across);
  plot.axes();
  testedBox(plot, tested, speeds, values.width, colours);
  plot.marker(values.u, start.y);
  return plot;
}

/** What the tests covered, where they said so. */
function testedBox(plot, { u, y }, [slowest, fastest], width, colours) {
  if (!u && !y) return;
  const [low, high] = u ?? [slowest - 1, fastest + 1];
  const [port, starboard] = y ?? [-width, width];
  const corners = [[low, port], [high, port], [high, starboard], [low, starboard], [low, port]];
  plot.line(corners, { stroke: colours.ink, width: 1.5, dash: [2, 3] });
}
