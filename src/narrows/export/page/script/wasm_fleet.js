// Fleets of ships by WebAssembly: what fleet.c exports.
//
// A task: {starts, parameters, told, steps, every}; starts has a row for each ship, its state and the length of its
// steps; parameters one row for all, or one for each. The answer: {ends, paths, kept}, as fleet_shape.js tells.
import { SEEN, rowsOf, rowLengths } from "./fleet_shape.js";

export async function wasmFleet(bytes, shape) {
  const { instance } = await WebAssembly.instantiate(bytes, {});
  const { memory, integrate, ...at } = instance.exports;
  const view = (Type, name, length) => new Type(memory.buffer, at[name](), length);

  function sailed({ starts, parameters, told, steps, every }) {
    const { ships, pathed } = rowsOf(starts, shape, every);
    view(Float64Array, "starts", starts.length).set(starts);
    view(Float64Array, "parameters", parameters.length).set(parameters);
    view(Float64Array, "told", told.length).set(told);
    integrate(ships, steps, every, parameters.length > shape.parameters ? 1 : 0);
    return {
      ends: view(Float64Array, "ends", ships * rowLengths(shape).end).slice(),
      paths: view(Float32Array, "paths", pathed * shape.samples * SEEN).slice(),
      kept: view(Int32Array, "kept", pathed).slice(),
    };
  }
  return { sailed, kind: "WebAssembly" };
}
