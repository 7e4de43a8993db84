// Which way the banks turn the bow, by offset and heading, with the voyage on it.
import { chart } from "./chart.js";
import { mixed, numbers } from "./colours.js";
import { DEGREE } from "./scenario.js";

const [COLUMNS, ROWS, WIDEST] = [120, 90, 30];
const LARGE = 0.97;
const [COSINE, SINE, YAW] = [2, 3, 6];

/** The yaw acceleration [rad/s2] that the banks give a ship: with them, less that in the middle between them. */
export function bankTurning(model, constants, inputs, state) {
  const middle = Float64Array.from(state);
  middle[1] = 0;
  return model.rates(state, inputs, constants)[YAW] - model.rates(middle, inputs, constants)[YAW];
}

export function turningField(model, constants, inputs, { start, width }) {
  const state = Float64Array.from(start);
  const [turning, clear, clearance] = [new Float64Array(COLUMNS * ROWS), [], [0, 0]];
  for (let cell = 0; cell < turning.length; cell += 1) {
    const psi = WIDEST * DEGREE * (2 * ((cell % COLUMNS) + 0.5) / COLUMNS - 1);
    state[1] = (Math.floor(cell / COLUMNS) + 0.5) / ROWS * width - width / 2;
    [state[COSINE], state[SINE]] = [Math.cos(psi), Math.sin(psi)];
    model.least_clearance(state, clearance, constants);
    turning[cell] = clearance[0] > 0 ? bankTurning(model, constants, inputs, state) : NaN;
    if (clearance[0] > 0) clear.push(Math.abs(turning[cell]));
  }
  clear.sort((one, other) => one - other);
  return { turning, most: clear[Math.floor(LARGE * (clear.length - 1))] || 1 };
}

export function drawField(canvas, height, { turning, most }, { values, start, alone, colours }) {
  const range = [-WIDEST, WIDEST];
  const plot = chart(canvas, height, { range, label: "heading, ° to starboard" }, values.width, colours);
  plot.cells(fieldCells(turning, most, colours), COLUMNS, ROWS);
  plot.axes();
  plot.line(alone.map(([, y, sine]) => [Math.asin(sine) / DEGREE, y]), { stroke: colours.ink, width: 2 });
  plot.marker(start.psi / DEGREE, start.y);
  return plot;
}

function fieldCells(turning, most, colours) {
  const pixels = new Uint8ClampedArray(4 * turning.length);
  const [land, water, port, starboard] = ["land", "panel", "port", "starboard"].map((name) => numbers(colours[name]));
  turning.forEach((value, cell) => {
    const size = Math.sqrt(Math.min(1, Math.abs(value) / most));
    const colour = Number.isNaN(value) ? land : mixed(water, value > 0 ? starboard : port, size);
    pixels.set([...colour, 255], 4 * cell);
  });
  return pixels;
}
