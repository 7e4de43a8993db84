// What the page shows now: the settings sailed, and every picture and sentence of it.
import { canalPicture } from "./canal_picture.js";
import { coloursOf } from "./colours.js";
import { bankTurning, drawField, turningField } from "./field_chart.js";
import { pathOf } from "./fleet_shape.js";
import { drawMap, mapCells } from "./map_chart.js";
import { model } from "./model.js";
import { PORT, SAILS, STARBOARD, metres, outcomes, sideOf } from "./outcome.js";
import { said } from "./sentences.js";

const LEVELS = [40, 100];
const PATIENCE = 1500; // [ms] that a finer map may take
const SQUARED = 5; // times as many cells, about
const ASKED = 400; // ships
const NARROW = "(max-width: 760px)";

export function sceneOf({ data, scenario, crew, here, settings, at }) {
  const { shape, ship, names } = data;
  const picture = canalPicture(at.canal, at.moving, { ...ship, view: scenario.view, open: data.open });
  const object = (keys, values) => Object.fromEntries(keys.map((key, place) => [key, values[place]]));
  const plots = {};
  let [run, colours, now, grown] = [0, coloursOf(), null, null];

  /** The ship as it is set, at once, and what the banks do to it. */
  function sailAlone() {
    const { values } = settings;
    const task = scenario.alone(values);
    const answer = here.sailed(task);
    const constants = model.prepare(object(names.parameters, task.parameters));
    const inputs = object(names.inputs, task.told);
    const current = values.current || 0;
    const path = overGround(pathOf(answer, 0, shape), task, current);
    const start = scenario.begun(values);
    const turning = (state) => bankTurning(model, constants, inputs, state);
    const seconds = task.every * task.starts[shape.states];
    const field = turningField(model, constants, inputs, { start: task.starts, width: values.width });
    return { values: { ...values }, start, path, seconds, turning, field, agree: now?.agree ?? 1, back: now?.back ?? 0, first: task.starts, alone: outcomes(answer, shape, current)[0] };
  }

  function overGround(path, { starts, every }, current) {
    const step = every * starts[shape.states];
    return path.map(([x, ...rest], place) => [x + current * Math.min(place * step, (path.length - 1) * step), ...rest]);
  }

  /** The sides to which the banks first turn some of the ships, from the start of the solid one. */
  function firstTurns({ parameters, told }) {
    const inputs = object(names.inputs, told);
    return Array.from({ length: Math.min(ASKED, parameters.length / shape.parameters - 1) }, (_, place) => {
      const row = (place + 1) * shape.parameters;
      const constants = model.prepare(object(names.parameters, parameters.subarray(row, row + shape.parameters)));
      return sideOf(bankTurning(model, constants, inputs, now.first));
    });
  }

  async function sailFan(mine) {
    const current = now.values.current || 0;
    const task = scenario.fan(now.values);
    const turns = data.banks ? firstTurns(task) : [];
    const share = (holds) => turns.filter(holds).length / turns.length;
    if (turns.length) now.agree = share((side) => side === sideOf(now.turning(now.first)));
    const answer = await crew.sailed(task, () => mine === run);
    if (mine !== run) return;
    now.ended = outcomes(answer, shape, current);
    const other = { [PORT]: STARBOARD, [STARBOARD]: PORT };
    const grounded = turns.filter((_, place) => other[now.ended[place + 1].kind]).length;
    now.back = turns.filter((side, place) => now.ended[place + 1].kind === other[side]).length / (grounded || 1);
    now.tracks = Array.from(answer.kept, (_, place) => place).slice(0, 700)
      .map((place) => overGround(pathOf(answer, place, shape), task, current).map(([x, y]) => [x, y]));
    draw();
  }

  async function sailMap(mine) {
    for (const across of [...LEVELS.filter((level) => level < now.values.map), now.values.map]) {
      const { cells, task } = scenario.map(now.values, across, data.speeds);
      const begun = performance.now();
      const answer = await crew.sailed(task, () => mine === run);
      if (mine !== run) return;
      now.map = { across, cells, ended: outcomes(answer, shape, now.values.current || 0) };
      now.mapped = performance.now() - begun;
      drawTheMap();
      if (now.mapped * SQUARED > PATIENCE) return;
    }
  }

  /** Sail again, as the settings are now; a picture that is overtaken stops. */
  async function changed() {
    const mine = (run += 1);
    const before = now;
    now = { ...sailAlone(), tracks: before?.tracks ?? [], ended: before?.ended ?? [], map: before?.map };
    drawAlone();
    await new Promise((painted) => setTimeout(painted));
    if (mine === run) await sailFan(mine);
    if (mine === run && !data.open) await sailMap(mine);
    if (mine === run) at.root.dataset.settled = mine;
  }

  const narrow = () => matchMedia(NARROW).matches;
  const height = () => (narrow() ? 260 : 212);

  function drawAlone() {
    picture.framed(now.values.width, colours, narrow());
    draw();
    if (data.banks) plots.field = drawField(at.field, height(), now.field, { ...now, alone: now.path, colours });
    if (now.map) drawTheMap();
  }

  function draw() {
    picture.draw({ tracks: now.tracks, ended: now.ended, alone: now.path });
    said(at, data, now, scenario.view);
    if (grown) step(grown);
  }

  function drawTheMap() {
    const { across } = now.map;
    const pixels = mapCells(now.map, across, colours, scenario.view, ship.length);
    const none = now.map.ended.every(({ kind }) => kind === SAILS);
    at.mapped.textContent = none ? `None of these ships meets a bank within ${metres(scenario.view)}.` : "";
    plots.map = drawMap(at.map, height(), { pixels, across }, { ...now, speeds: data.speeds, tested: data.tested, colours });
  }

  /** The moving ship at a share of its voyage. */
  function step(share) {
    grown = share;
    const place = share * (now.path.length - 1);
    const one = Math.min(Math.floor(place), now.path.length - 2);
    const [x, y, sine] = now.path[one].map((value, index) => value + (place - one) * (now.path[one + 1][index] - value));
    const state = Float64Array.from(now.first);
    [state[1], state[2], state[3]] = [y, Math.sqrt(1 - sine * sine), sine];
    const turning = now.turning(state) / now.field.most;
    const sweep = Math.abs(turning) < 1e-3 ? 0 : Math.sign(turning) * (0.3 + 0.6 * Math.min(1, Math.sqrt(Math.abs(turning))));
    picture.move({ x, y, sine, turning: sweep, side: turning > 0 ? "starboard" : "port" });
  }

  function recoloured() {
    colours = coloursOf();
    if (now) drawAlone();
  }
  return { changed, step, recoloured, plots, get now() { return now; }, get run() { return run; } };
}
