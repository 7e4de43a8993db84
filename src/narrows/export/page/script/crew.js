// Workers, one a core, that share the ships of a task; without them the page sails by itself.
import { SEEN, rowLengths } from "./fleet_shape.js";

/** `source` is the text of the worker, `here` the fleet to use where no worker starts. */
export function crewOf(source, data, here, hands = navigator.hardwareConcurrency || 2) {
  const workers = startedWorkers(source, data, hands);

  /** What becomes of a task; nothing where it is not wanted any more before its turn has come. */
  async function sailed(task, wanted = () => true) {
    const parts = divided(task, data.shape, workers.length || 1);
    const answers = await Promise.all(parts.map((part, place) => queued(workers[place % workers.length], part, wanted)));
    return answers.every(Boolean) ? joined(answers) : null;
  }

  function queued(worker, part, wanted) {
    if (!worker) return here.sailed(part);
    const answer = worker.queue.then(() => wanted() && answered(worker.port, part)).catch(() => here.sailed(part));
    worker.queue = answer;
    return answer;
  }
  return { sailed, hands: workers.length };
}

function answered(port, part) {
  return new Promise((resolve, reject) => {
    port.onmessage = ({ data: answer }) => resolve(answer);
    port.onerror = reject;
    port.postMessage(part);
  });
}

function startedWorkers(source, data, hands) {
  try {
    const place = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    return Array.from({ length: Math.max(1, Math.min(hands, 16)) }, () => {
      const port = new Worker(place);
      port.postMessage(data);
      return { port, queue: Promise.resolve() };
    });
  } catch {
    return [];
  }
}

/** Parts of a task, no larger than a fleet takes at once, as many for each worker. */
function divided(task, shape, hands) {
  const row = rowLengths(shape).start;
  const ships = task.starts.length / row;
  const each = task.parameters.length > shape.parameters;
  const size = Math.max(1, Math.min(shape.most, task.every ? shape.paths : shape.most, Math.ceil(ships / hands)));
  return Array.from({ length: Math.ceil(ships / size) }, (_, part) => {
    const [from, to] = [part * size, Math.min(ships, (part + 1) * size)];
    const parameters = each ? task.parameters.slice(from * shape.parameters, to * shape.parameters) : task.parameters;
    return { ...task, starts: task.starts.slice(from * row, to * row), parameters };
  });
}

function joined(answers) {
  const whole = (Type, name) => {
    const all = new Type(answers.reduce((sum, one) => sum + one[name].length, 0));
    answers.reduce((at, one) => (all.set(one[name], at), at + one[name].length), 0);
    return all;
  };
  return { ends: whole(Float64Array, "ends"), paths: whole(Float32Array, "paths"), kept: whole(Int32Array, "kept") };
}
