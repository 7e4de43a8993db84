// Draws a canal from above, to scale, on a 2-D canvas, and nothing else.
//
// Metres in a plane: `along` one axis and `across` to starboard of it; headings in radians, clockwise from `along`.
// Of a straight canal they are its own; of a map, north and east. A point is [along, across]. A style names colours of
// the palette, or gives CSS ones: {stroke, fill, width [px], dash [px], opacity}.

const COLOURS = ["land", "water", "bank", "ship", "hull", "track", "fan", "ink"];
const BAR = { from: 70, margin: 16, tick: 5, steps: [1, 2, 5, 10] };
const HULL = [
  // Of the length from midship, of the beam from the middle line: the starboard side, stern to bow.
  [-0.5, 0.36], [-0.47, 0.46], [-0.4, 0.5], [0.3, 0.5], [0.38, 0.44], [0.45, 0.28], [0.49, 0.09], [0.5, 0],
];

/** Colours of the palette in use, from the custom properties --canal-* of an element. */
export function canalColours(element) {
  const style = getComputedStyle(element);
  return Object.fromEntries(COLOURS.map((name) => [name, style.getPropertyValue(`--canal-${name}`).trim()]));
}

/** What draws on a canvas. `colours` is asked at every stroke: change it, and look again, to change the palette. */
export function canalView(canvas, colours) {
  const pen = canvas.getContext("2d");
  const camera = { along: 0, across: 0, metresPerPixel: 1, heading: 0, right: 0.5, down: 0.5 };

  const colour = (name) => colours[name] ?? name;
  const origin = () => [camera.right * canvas.clientWidth, camera.down * canvas.clientHeight];

  function toPixels([along, across]) {
    const [ahead, right] = turned(along - camera.along, across - camera.across, -camera.heading);
    const [x, y] = origin();
    return [x + right / camera.metresPerPixel, y - ahead / camera.metresPerPixel];
  }

  function toMetres(px, py) {
    const [x, y] = origin();
    const metres = camera.metresPerPixel;
    const [along, across] = turned((y - py) * metres, (px - x) * metres, camera.heading);
    return [camera.along + along, camera.across + across];
  }

  function path(points, closed = false) {
    pen.beginPath();
    points.forEach((point, place) => pen[place ? "lineTo" : "moveTo"](...toPixels(point)));
    if (closed) pen.closePath();
  }

  function paint({ stroke, fill, width = 1.5, dash = [], opacity = 1 }) {
    pen.globalAlpha = opacity;
    pen.lineWidth = width;
    pen.lineJoin = pen.lineCap = "round";
    pen.setLineDash(dash);
    if (fill) (pen.fillStyle = colour(fill)), pen.fill();
    if (stroke) (pen.strokeStyle = colour(stroke)), pen.stroke();
    pen.globalAlpha = 1;
  }

  /** Puts a point at `right`, `down` of the canvas (0 to 1, its middle unless given), the heading up; clears all. */
  function look(wanted) {
    Object.assign(camera, wanted);
    sized(canvas, pen);
    pen.fillStyle = colour("land");
    pen.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  }

  /** The water between two banks, each a polyline. */
  function water([one, other]) {
    path([...one, ...[...other].reverse()], true);
    paint({ fill: "water" });
    for (const bank of [one, other]) path(bank), paint({ stroke: "bank", width: 2.5 });
  }

  /** A hull, its midship at a pose {along, across, heading}. */
  function ship(pose, { length, beam }, style = { stroke: "ship", fill: "hull" }) {
    const sides = [...HULL, ...HULL.map(([forward, out]) => [forward, -out]).reverse()];
    const corner = ([forward, out]) => {
      const [along, across] = turned(forward * length, out * beam, pose.heading);
      return [pose.along + along, pose.across + across];
    };
    path(sides.map(corner), true);
    paint(style);
  }

  function track(points, style = { stroke: "track", width: 2 }) {
    path(points);
    paint(style);
  }

  /** Many tracks, each faint, so that where most of them go is darkest. */
  function fan(tracks, style = { stroke: "fan", width: 3, opacity: 0.12 }) {
    for (const points of tracks) track(points, style);
  }

  /** A bar of 1, 2 or 5 times a power of ten in metres, at the lower left. */
  function scaleBar() {
    const metres = rounded(BAR.from * camera.metresPerPixel);
    const [left, y] = [BAR.margin, canvas.clientHeight - BAR.margin];
    const right = left + metres / camera.metresPerPixel;
    pen.beginPath();
    pen.moveTo(left, y - BAR.tick), pen.lineTo(left, y), pen.lineTo(right, y), pen.lineTo(right, y - BAR.tick);
    paint({ stroke: "ink", width: 2 });
    pen.fillStyle = colour("ink");
    pen.font = "600 13px system-ui, sans-serif";
    pen.textBaseline = "bottom";
    pen.fillText(metres < 1000 ? `${metres} m` : `${metres / 1000} km`, left + 6, y - BAR.tick);
  }

  return { look, water, ship, track, fan, scaleBar, toMetres, toPixels };
}

/** A vector of the plane, turned clockwise by an angle. */
function turned(along, across, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return [along * cos - across * sin, along * sin + across * cos];
}

/** The next of 1, 2, 5, 10 ... that is no less. */
function rounded(metres) {
  const power = 10 ** Math.floor(Math.log10(metres));
  return power * BAR.steps.find((step) => step * power >= metres);
}

/** As many pixels as the screen has under the canvas, counted in those of CSS. */
function sized(canvas, pen) {
  const ratio = globalThis.devicePixelRatio || 1;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
}
