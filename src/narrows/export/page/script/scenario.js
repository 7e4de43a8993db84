// What is asked of a fleet: settings of the page as tasks, lengths of the picture, and a ship's start that has room.
import { drawing, normals } from "./draws.js";
import { rowLengths } from "./fleet_shape.js";

export const DEGREE = Math.PI / 180;
const STEPS_A_LENGTH = { fan: 200, map: 100 };
const MARGIN = 0.02;

/** `data` is what Python wrote into the page; `values` the settings of now. */
export function scenarioOf(data) {
  const { shape, ship, names } = data;
  const { start: row } = rowLengths(shape);
  const size = data.coefficients.length;
  const most = data.sliders.find(({ name }) => name === "ships").high;
  let drawn;
  const chance = () => (drawn ??= normals(most + 1, size + 2));
  const draw = drawing(data.root, data.coefficients.map(({ bounds }) => bounds));
  const view = data.lengths * ship.length;

  const rowOf = (y, psi, u, rudder, step) => {
    const state = new Float64Array(row);
    state.set([0, y, Math.cos(psi), Math.sin(psi), u]);
    for (const place of shape.turned) state[place] = rudder;
    state[shape.states] = step;
    return state;
  };

  /** How far off the middle a hull may be, half of what it takes off; below zero where it does not fit. */
  const freedom = (values, psi) =>
    values.width / 2 - ship.beam / 2 * Math.cos(psi) - ship.length / 2 * Math.abs(Math.sin(psi)) - MARGIN * ship.beam;

  /** Where the ship starts: as it is set, or as near to that as there is room. */
  function begun(values) {
    const psi = freedom(values, values.psi * DEGREE) > 0 ? values.psi * DEGREE : 0;
    const most = freedom(values, psi);
    const y = Math.max(-most, Math.min(most, values.y));
    return { y, psi, moved: y !== values.y || psi !== values.psi * DEGREE };
  }

  function parametersOf(values, coefficients = data.coefficients.map(({ name }) => values[name])) {
    const parameters = Float64Array.from(data.parameters);
    const set = (name, value) => names.parameters.includes(name) && (parameters[names.parameters.indexOf(name)] = value);
    data.coefficients.forEach(({ name }, place) => set(name, coefficients[place]));
    for (const name of ["width", "depth"]) if (name in values) set(name, values[name]);
    return parameters;
  }

  function toldOf(values) {
    const told = Float64Array.from(data.inputs);
    const set = (name, value) => names.inputs.includes(name) && (told[names.inputs.indexOf(name)] = value);
    set("law_steers", values.helm ? 1 : -1);
    set("law_ordered", (values.rudder || 0) * DEGREE);
    set("rudder_order", (values.rudder || 0) * DEGREE);
    if ("revolutions" in values) set("revolutions", values.revolutions);
    return told;
  }

  const pace = (values, u, kind) => ship.length / STEPS_A_LENGTH[kind] / (u + (values.current || 0));
  const steps = (kind) => Math.ceil(data.lengths * STEPS_A_LENGTH[kind]);
  const alike = (values) => ({ told: toldOf(values), steps: steps("fan"), every: Math.ceil(steps("fan") / (shape.samples - 1)) });

  /** The ship as it is set, alone. */
  function alone(values) {
    const { y, psi } = begun(values);
    const starts = rowOf(y, psi, values.u, (values.rudder || 0) * DEGREE, pace(values, values.u, "fan"));
    return { ...alike(values), starts, parameters: parametersOf(values) };
  }

  /** Ships that start about there, each with coefficients of its own. */
  function fan(values) {
    const { y, psi } = begun(values);
    const step = pace(values, values.u, "fan");
    const mean = data.coefficients.map(({ name }) => values[name]);
    const [starts, parameters] = [new Float64Array(values.ships * row), new Float64Array(values.ships * shape.parameters)];
    const base = parametersOf(values);
    const places = data.coefficients.map(({ name }) => names.parameters.indexOf(name));
    for (let ship = 0; ship < values.ships; ship += 1) {
      const normal = chance().subarray(ship * (size + 2), (ship + 1) * (size + 2));
      const [offset, heading] = [y + values.sd_y * normal[size], psi + values.sd_psi * DEGREE * normal[size + 1]];
      starts.set(rowOf(offset, heading, values.u, (values.rudder || 0) * DEGREE, step), ship * row);
      parameters.set(base, ship * shape.parameters);
      const scaled = Array.from(normal.subarray(0, size), (number) => values.doubt * number);
      draw(mean, scaled).forEach((value, place) => { parameters[ship * shape.parameters + places[place]] = value; });
    }
    return { ...alike(values), starts, parameters };
  }

  /** A ship in the middle of each cell of the map that has room for it; `cells` says which cells those are. */
  function map(values, across, [slowest, fastest]) {
    const { psi } = begun(values);
    const most = freedom(values, psi);
    const yOf = (cell) => ((Math.floor(cell / across) + 0.5) / across - 0.5) * values.width;
    const cells = Array.from({ length: across * across }, (_, cell) => cell).filter((cell) => Math.abs(yOf(cell)) < most);
    const like = rowOf(0, psi, 0, (values.rudder || 0) * DEGREE, 0);
    const starts = new Float64Array(cells.length * row);
    cells.forEach((cell, place) => {
      const u = slowest + ((cell % across) + 0.5) / across * (fastest - slowest);
      starts.set(like, place * row);
      starts[place * row + 1] = yOf(cell);
      starts[place * row + 4] = u;
      starts[place * row + shape.states] = pace(values, u, "map");
    });
    return { cells, task: { starts, parameters: parametersOf(values), told: toldOf(values), steps: steps("map"), every: 0 } };
  }

  return { alone, fan, map, begun, parametersOf, toldOf, rowOf, view };
}
