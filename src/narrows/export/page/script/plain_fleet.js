// Fleets of ships by plain JavaScript, one after another: what wasm_fleet.js does where there is no WebAssembly.
import { AFLOAT, SEEN, rowLengths, rowsOf, seen } from "./fleet_shape.js";

/** `model` is the exported module; `names` says its parameters and inputs in order. */
export function plainFleet(model, shape, names) {
  const object = (keys, values) => Object.fromEntries(keys.map((key, place) => [key, values[place]]));
  const size = rowLengths(shape);

  function sailed({ starts, parameters, told, steps, every }) {
    const { ships, pathed } = rowsOf(starts, shape, every);
    const inputs = object(names.inputs, told);
    const paths = new Float32Array(pathed * shape.samples * SEEN);
    const [ends, kept] = [new Float64Array(ships * size.end), new Int32Array(pathed)];
    let constants;
    for (let ship = 0; ship < ships; ship += 1) {
      const row = ship * shape.parameters;
      if (!ship || parameters.length > row) {
        constants = model.prepare(object(names.parameters, parameters.subarray(row, row + shape.parameters)));
      }
      const start = starts.subarray(ship * size.start, (ship + 1) * size.start);
      const watched = ship < pathed ? every : steps;
      const path = paths.subarray(ship * shape.samples * SEEN, (ship + 1) * shape.samples * SEEN);
      const { end, samples } = voyage(start, constants, inputs, steps, watched, path);
      ends.set(end, ship * size.end);
      if (ship < pathed) kept[ship] = samples;
    }
    return { ends, paths, kept };
  }

  function voyage(start, constants, inputs, steps, every, path) {
    const state = Float64Array.from(start.subarray(0, shape.states));
    const [step, end] = [start[shape.states], [0, 0]];
    let [outcome, time, samples, taken] = [AFLOAT, 0, 0, 0];
    const keep = () => SEEN * samples < path.length && path.set(seen(state, shape), SEEN * samples++);
    for (; taken < steps && outcome === AFLOAT; taken += every) {
      keep();
      const next = Math.min(every, steps - taken);
      outcome = model.integrate(state, inputs, constants, step, next * step, end);
      time += end[0];
    }
    return { end: [...state, time, outcome], samples };
  }
  return { sailed, kind: "JavaScript" };
}
