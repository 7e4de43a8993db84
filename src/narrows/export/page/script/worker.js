// A worker: the fleet that its first message tells of, then a task after another.
import { plainFleet } from "./plain_fleet.js";
import { wasmFleet } from "./wasm_fleet.js";
import { unpacked } from "./unpacked.js";
import { model } from "./model.js";

let fleet;

async function fleetOf({ wasm, shape, names }) {
  if (!wasm) return plainFleet(model, shape, names);
  try {
    return await wasmFleet(await unpacked(wasm), shape);
  } catch {
    return plainFleet(model, shape, names);
  }
}

onmessage = async ({ data }) => {
  if (!fleet) fleet = fleetOf(data);
  else {
    const answer = (await fleet).sailed(data);
    postMessage(answer, Object.values(answer).map((array) => array.buffer));
  }
};
