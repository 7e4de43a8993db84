// Ships that are not alike: starts and coefficients drawn from normal distributions, the same at every visit.

const PASSES = 3;

/** Rows of standard normal numbers, by mulberry32 and Box and Muller; the first row is zero: the ship as it is set. */
export function normals(rows, columns, seed = 1) {
  const uniform = generator(seed);
  const drawn = new Float64Array(rows * columns);
  for (let at = columns; at < drawn.length; at += 2) {
    const [size, turn] = [Math.sqrt(-2 * Math.log(1 - uniform())), 2 * Math.PI * uniform()];
    drawn[at] = size * Math.cos(turn);
    if (at + 1 < drawn.length) drawn[at + 1] = size * Math.sin(turn);
  }
  return drawn;
}

function generator(seed) {
  let state = seed | 0;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}

/** What draws coefficients: mean + normal . root, brought back to their bounds with what is correlated moving along. */
export function drawing(rows, bounds) {
  const size = rows.length;
  const root = rows.map((row, i) => (Array.isArray(row) ? row : rows.map((value, j) => (i === j ? value : 0))));
  const covariance = root.map((_, i) => root.map((_, j) => root.reduce((sum, row) => sum + row[i] * row[j], 0)));
  const spread = covariance.map((row, k) => row[k]);

  function within(drawn) {
    for (let pass = 0; pass < PASSES; pass += 1) {
      for (let k = 0; k < size; k += 1) {
        const shift = clamped(drawn[k], bounds[k]) - drawn[k];
        if (shift && spread[k] > 0) for (let j = 0; j < size; j += 1) drawn[j] += shift * covariance[k][j] / spread[k];
      }
    }
    return drawn.map((value, k) => clamped(value, bounds[k]));
  }

  return (mean, normal) => within(mean.map((value, j) => root.reduce((sum, row, i) => sum + normal[i] * row[j], value)));
}

const clamped = (value, [low, high]) => Math.min(high ?? Infinity, Math.max(low ?? -Infinity, value));
