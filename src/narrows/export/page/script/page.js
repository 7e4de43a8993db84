// The page: settings, a crew of workers, a scene; what clicks, keys, the address and the clock do to them.
import { crewOf } from "./crew.js";
import { plainFleet } from "./plain_fleet.js";
import { model } from "./model.js";
import { savePicture } from "./picture.js";
import { scenarioOf } from "./scenario.js";
import { sceneOf } from "./scene.js";
import { controls, hashOf, settingsOf } from "./settings.js";

const PALETTES = ["day", "dusk", "night"];
const SECONDS = 7;
const REST = 1.15;
const KEYS = { ArrowLeft: ["u", -1], ArrowRight: ["u", 1], ArrowUp: ["y", -1], ArrowDown: ["y", 1] };

const data = JSON.parse(document.getElementById("data").textContent);
const at = Object.fromEntries([...document.querySelectorAll("[id]")].map((element) => [element.id, element]));
at.root = document.documentElement;
const here = plainFleet(model, data.shape, data.names);
const crew = crewOf(`${at.shared.textContent}\n${at.worker.textContent}`, data, here);
const settings = settingsOf(data, location.hash);
const scenario = scenarioOf(data);
const scene = sceneOf({ data, scenario, crew, here, settings, at });
const show = controls(at.controls, data, settings, changed);

let waiting = false;
function changed() {
  show();
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    try { history.replaceState(null, "", `#${hashOf(settings)}`); } catch { /* an embedded page may not */ }
    scene.changed();
  });
}

function put(name, value) {
  const { low, high, step } = data.sliders.find((slider) => slider.name === name);
  settings.values[name] = Math.min(high, Math.max(low, Math.round(value / step) * step));
}

/** A click or a drag on a picture sets what lies there. */
function picking(canvas, plot, set) {
  const picked = (event) => {
    if (event.type === "pointermove" && !event.buttons) return;
    const { left, top } = canvas.getBoundingClientRect();
    set(scene.plots[plot]?.under(event.clientX - left, event.clientY - top));
  };
  for (const kind of ["pointerdown", "pointermove"]) canvas.addEventListener(kind, picked);
}
const setting = (name) => (point) => {
  if (!point) return;
  put(name, point[0]), put("y", point[1]);
  changed();
};
picking(at.map, "map", setting("u"));
picking(at.field, "field", setting("psi"));
at.map.addEventListener("keydown", (event) => {
  const [name, by] = KEYS[event.key] ?? [];
  if (!name) return;
  event.preventDefault();
  put(name, settings.values[name] + by * 5 * data.sliders.find((slider) => slider.name === name).step);
  changed();
});

/** Day, dusk and night; what the machine prefers at first. */
function palette(name) {
  at.root.dataset.palette = name;
  at.palette.textContent = { day: "☀ day", dusk: "◐ dusk", night: "☾ night" }[name];
  scene.recoloured();
}
at.palette.addEventListener("click", () => palette(PALETTES[(PALETTES.indexOf(at.root.dataset.palette) + 1) % 3]));
palette(matchMedia("(prefers-color-scheme: dark)").matches ? "dusk" : "day");

let [playing, clock, before] = [!matchMedia("(prefers-reduced-motion: reduce)").matches, 0, 0];
function animated(time) {
  const passed = Math.min(50, time - before) / 1000 / SECONDS;
  [clock, before] = [playing ? (clock + passed) % REST : clock, time];
  if (scene.now) scene.step(Math.min(1, clock) || 1e-6);
  requestAnimationFrame(animated);
}
at.play.addEventListener("click", () => {
  playing = !playing;
  at.play.textContent = playing ? "❚❚ pause" : "▶ play";
});
at.play.textContent = playing ? "❚❚ pause" : "▶ play";
at.save.addEventListener("click", () => savePicture(data, at));
addEventListener("resize", () => scene.recoloured());
addEventListener("hashchange", () => {
  Object.assign(settings.values, settingsOf(data, location.hash).values);
  changed();
});
changed();
requestAnimationFrame(animated);
globalThis.narrowsPage = { settings, scene, changed, crew, scenario };
