// A soft shadow on the ground: the blocks seen from above, blurred.

const SHADOW_SIZE = 128; // [pixels]
const SHADOW_ROOM = 1.6; // side of the ground by that of the model
const SHADOW_BLUR = 5; // [pixels], three times

function shadowOf(data) {
  const side = Math.max(data.half[0], data.half[1], 1e-9) * SHADOW_ROOM;
  const values = new Float32Array(SHADOW_SIZE * SHADOW_SIZE);
  const { point } = data.blocks;
  const first = starts(data.blocks.points);
  const pixel = (x) => ((x / side + 1) / 2) * SHADOW_SIZE;
  for (let block = 0; block < data.count; block++) {
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    for (let p = 3 * first[block]; p < 3 * first[block + 1]; p += 3) {
      for (let i = 0; i < 2; i++) {
        low[i] = Math.min(low[i], pixel(point[p + i]));
        high[i] = Math.max(high[i], pixel(point[p + i]));
      }
    }
    // The box around a block, a little smaller: most blocks do not fill theirs.
    const [x0, y0] = low.map((x) => Math.max(0, Math.floor(x)));
    const [x1, y1] = high.map((x) => Math.min(SHADOW_SIZE, Math.ceil(x)));
    for (let y = y0; y < y1; y++) for (let x = x0; x < x1; x++) values[y * SHADOW_SIZE + x] = 1;
  }
  for (let round = 0; round < 3; round++) {
    blurRows(values, SHADOW_SIZE, 1);
    blurRows(values, 1, SHADOW_SIZE);
  }
  return { side, pixels: Uint8Array.from(values, (x) => Math.round(255 * x)) };
}

// Running mean along rows that are `stride` numbers apart, in steps of `step`.
function blurRows(values, stride, step) {
  const width = 2 * SHADOW_BLUR + 1;
  const line = new Float32Array(SHADOW_SIZE);
  for (let row = 0; row < SHADOW_SIZE; row++) {
    const start = row * stride;
    let sum = 0;
    for (let i = 0; i < SHADOW_SIZE; i++) line[i] = values[start + i * step];
    for (let i = -SHADOW_BLUR; i < SHADOW_SIZE; i++) {
      sum += (line[i + SHADOW_BLUR] ?? 0) - (line[i - SHADOW_BLUR - 1] ?? 0);
      if (i >= 0) values[start + i * step] = sum / width;
    }
  }
}
