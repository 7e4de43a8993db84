// How the numbers of a fleet lie in arrays: a shape is {states, parameters, most, paths, samples, rudder}.

/** Numbers of a point of a path: x, y, sine of the heading, rudder. */
export const SEEN = 4;
export const [AFLOAT, AGROUND, DIVERGED, OUTSIDE] = [0, 1, 2, 3];

/** Numbers of a row: of a start, the state and the step; of an end, the state, the time and the outcome. */
export const rowLengths = ({ states }) => ({ start: states + 1, end: states + 2 });

export function rowsOf(starts, shape, every) {
  const ships = starts.length / rowLengths(shape).start;
  return { ships, pathed: every ? Math.min(ships, shape.paths) : 0 };
}

/** The path of a ship, as [x, y, sine of the heading, rudder], to where it ends. */
export function pathOf({ ends, paths, kept }, ship, shape) {
  const points = Array.from({ length: kept[ship] }, (_, sample) => {
    const at = (ship * shape.samples + sample) * SEEN;
    return [...paths.subarray(at, at + SEEN)];
  });
  return [...points, seen(ends.subarray(ship * rowLengths(shape).end), shape)];
}

export function seen(state, { rudder }) {
  return [state[0], state[1], state[3], rudder < 0 ? 0 : state[rudder]];
}
