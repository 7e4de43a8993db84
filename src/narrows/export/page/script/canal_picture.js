// The canal from above: a fan of ships, where they ground as histograms growing into the banks, and the ship itself.
import { canalView } from "../../../web/canal.js";
import { PORT, STARBOARD, metres as written } from "./outcome.js";

const SHOWN = 600;
const BINS = 90;
const ROOM = { bank: 62, narrow: 40, behind: 0.85, ahead: 0.35 };
const TALLEST = 330;
const LEAST = 0.5; // share of the picture's width that the voyage takes, however wide the canal
const LYING = 24;
const ENLARGED = [1, 4]; // times the width of a phone, which follows the ship
const DEEP = 64; // [px] width of the canal there, if that suffices

/** `back` is the canvas of what stands, `front` that of what moves. */
export function canalPicture(back, front, { length, beam, view, open }) {
  const hull = { length, beam };
  let camera, colours, width, bank, followed;
  const views = () => [canalView(back, colours), canalView(front, { ...colours, land: "transparent" })];

  /** The whole voyage across the canvas, at one scale; of a canal that is too wide for it the middle. */
  function framed(of, palette, narrow) {
    [width, colours, bank] = [of, palette, narrow ? ROOM.narrow : ROOM.bank];
    const strip = back.parentElement;
    const along = view + (ROOM.behind + ROOM.ahead) * length;
    const times = Math.min(ENLARGED[1], Math.max(ENLARGED[0], (DEEP * along) / width / strip.clientWidth));
    const space = strip.clientWidth * (narrow ? times : 1);
    const wide = space > strip.clientWidth;
    strip.tabIndex = wide ? 0 : -1;
    strip.parentElement.classList.toggle("wide", wide);
    const tallest = narrow ? TALLEST / 2 : TALLEST;
    const metres = Math.max(along / space, Math.min(width / tallest, along / space / LEAST));
    for (const canvas of [back, front]) Object.assign(canvas.style, { width: `${space}px`, height: `${Math.min(width / metres, tallest) + 2 * bank}px` });
    camera = { along: -ROOM.behind * length, across: 0, metresPerPixel: metres, right: 0, down: 0.5, heading: -Math.PI / 2 };
  }

  function draw({ tracks, ended, alone }) {
    const [canal] = views();
    canal.look(camera);
    const [from, to] = [-3 * length, camera.along + back.clientWidth * camera.metresPerPixel];
    canal.water([-1, 1].map((side) => [[from, side * width / 2], [to, side * width / 2]]));
    canal.track([[from, 0], [to, 0]], { stroke: "ink", width: 1, dash: [6, 9], opacity: 0.25 });
    fans(canal, tracks, ended);
    for (const side of [PORT, STARBOARD]) histogram(canal, ended, side);
    lying(canal, ended);
    canal.track(alone.map(([x, y]) => [x, y]), { stroke: "ship", width: 1.8 });
    for (const [x, y, sine] of [alone[0], alone.at(-1)]) {
      canal.ship({ along: x, across: y, heading: Math.asin(sine) }, hull, { stroke: "ship", fill: "panel", width: 1.4, opacity: 0.75 });
    }
    if (!open) words(canal);
    canal.scaleBar();
  }

  function fans(canal, tracks, ended) {
    const opacity = Math.min(0.5, 40 / Math.min(SHOWN, tracks.length));
    const kinds = { sails: "soft", lost: "soft", [STARBOARD]: "starboard", [PORT]: "port" };
    for (const [kind, stroke] of Object.entries(kinds)) {
      const own = tracks.filter((_, ship) => ship && ship < SHOWN && ended[ship].kind === kind);
      canal.fan(own, { stroke, width: 1.5, opacity });
    }
  }

  /** Where some of the others lie. */
  function lying(canal, ended) {
    const grounded = ended.filter(({ kind }, ship) => ship && (kind === PORT || kind === STARBOARD));
    const each = Math.max(1, Math.floor(grounded.length / LYING));
    for (let place = 0; place < grounded.length; place += each) {
      const { kind, x, y, sine } = grounded[place];
      canal.ship({ along: x, across: y, heading: Math.asin(sine) }, hull, { stroke: kind, width: 1, opacity: 0.35 });
    }
  }

  function histogram(canal, ended, side) {
    const counts = new Float64Array(BINS);
    const size = view / BINS;
    for (const { kind, x } of ended) if (kind === side && x >= 0 && x < view) counts[Math.floor(x / size)] += 1;
    const most = Math.max(...counts, ended.length * 0.03);
    const deep = (bank - 22) * camera.metresPerPixel;
    const out = (side === PORT ? -1 : 1);
    counts.forEach((count, bin) => {
      if (!count) return;
      const [near, far] = [out * width / 2, out * (width / 2 + deep * count / most)];
      const [one, other] = [(bin + 0.08) * size, (bin + 0.92) * size];
      canal.track([[one, near], [one, far], [other, far], [other, near]], { fill: side });
    });
  }

  function words(canal) {
    const [pen, narrow] = [back.getContext("2d"), bank < ROOM.bank];
    pen.font = "600 12px system-ui, sans-serif";
    for (const [side, sign] of [[PORT, -1], [STARBOARD, 1]]) {
      const y = canal.toPixels([camera.along, sign * width / 2])[1] + sign * (narrow ? bank - 9 : 14); // On a phone outside the bars
      const [tall, below] = [back.clientHeight, y > back.clientHeight];
      const end = below ? tall - 44 : Math.max(9, y); // The scale stands below.
      const name = below || y < 0 ? `${side} bank: ${written(width / 2)} from the middle` : `${side} bank`;
      pen.fillStyle = colours[side];
      pen.textBaseline = "middle";
      pen.textAlign = narrow ? "right" : "left"; // On a phone the scale stands at the left.
      pen.fillText(name, narrow ? back.parentElement.clientWidth - 12 : 12, end);
    }
    pen.textAlign = "left";
  }

  /** The ship on its way, with an arrow at its bow that says which way the banks turn it. */
  function move({ x, y, sine, turning, side }) {
    const [, canal] = views();
    front.getContext("2d").clearRect(0, 0, front.width, front.height);
    canal.look(camera);
    const heading = Math.asin(sine);
    const strip = back.parentElement;
    if (x !== followed) strip.scrollLeft = canal.toPixels([x, y])[0] - strip.clientWidth / 2;
    followed = x; // A picture that stands may be swiped.
    canal.ship({ along: x, across: y, heading }, hull, { fill: "ship", stroke: "panel", width: 1.2 });
    if (turning) arrow(canal, { x, y, heading, turning, side });
  }

  /** An arc about midship, ahead of the bow: longer where the banks turn harder. */
  function arrow(canal, { x, y, heading, turning, side }) {
    const [reach, sweep] = [0.66 * length, turning];
    const at = (angle, far = reach) => [x + far * Math.cos(heading + angle), y + far * Math.sin(heading + angle)];
    const arc = Array.from({ length: 13 }, (_, place) => at(sweep * place / 12));
    canal.track(arc, { stroke: side, width: 5 });
    const back = sweep - Math.sign(sweep) * 0.16;
    canal.track([at(back, reach * 1.12), at(sweep + Math.sign(sweep) * 0.05), at(back, reach * 0.88)], { stroke: side, fill: side, width: 2 });
  }

  return { framed, draw, move };
}
