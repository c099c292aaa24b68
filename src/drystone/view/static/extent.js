// What a view has to hold: blocks, where they move to, and the arrows of forces.

const MOST_POINTS = 100000; // corners looked at
const SUPPORT = 2; // the state of a support
const AROUND = 0.15; // of supports, by the size of what is free
const WHOLE = 2.5; // times that size, up to which supports are seen whole: half a plank under a block looks cut off

// Places (three numbers each) with the model taken apart by `spread`.
function placesAt(spread) {
  return new Float32Array([...cornersAt(spread), ...motionEnds(), ...(spread ? [] : arrowEnds())]);
}

// Corners of the blocks, every so-many-th where there are many. Of large supports those near what is free: a slab
// under a column is not what one looks at.
function cornersAt(spread) {
  const { away } = data.blocks;
  const places = [];
  const near = nearFree();
  someCorners((p, block) => {
    const support = supports(block);
    for (let i = 0; i < 3; i++) {
      const at = p[i] + spread * away[3 * block + i];
      places.push(support ? Math.min(near.high[i], Math.max(near.low[i], at)) : at);
    }
  });
  return places;
}

const supports = (block) => stage().state[block] === SUPPORT;

// The box around what is free, and a margin around it; without limits where nothing is free, or all is not much larger.
function nearFree() {
  const [low, high, least, most] = [Infinity, -Infinity, Infinity, -Infinity].map((x) => [x, x, x]);
  someCorners((p, block) => {
    for (let i = 0; i < 3; i++) {
      [least[i], most[i]] = [Math.min(least[i], p[i]), Math.max(most[i], p[i])];
      if (!supports(block)) [low[i], high[i]] = [Math.min(low[i], p[i]), Math.max(high[i], p[i])];
    }
  });
  const size = vec.length(vec.sub(high, low));
  if (!(size < Infinity) || vec.length(vec.sub(most, least)) <= WHOLE * size) {
    return { low: low.map(() => -Infinity), high: high.map(() => Infinity) };
  }
  const margin = AROUND * size;
  return { low: low.map((x) => x - margin), high: high.map((x) => x + margin) };
}

function someCorners(use) {
  const { point, points } = data.blocks;
  const step = Math.max(1, Math.ceil(point.length / 3 / MOST_POINTS));
  let p = 0;
  for (let block = 0; block < data.count; block++) {
    for (let k = 0; k < points[block]; k++, p++) {
      if (p % step === 0) use(point.subarray(3 * p, 3 * p + 3), block);
    }
  }
}

// Where a motion that plays by itself leads or the forces of a stage are, and the way of blocks that are placed.
function motionEnds() {
  const places = [];
  const { centroid, point, points } = data.blocks;
  const middle = (block) => centroid.subarray(3 * block, 3 * block + 3);
  const first = starts(points);
  for (const { arrives, plays, moved, motion } of data.stages) {
    if (!motion || !(arrives || plays || moved)) continue;
    const way = (block) => motion.subarray(6 * block, 6 * block + 3);
    if (arrives) {
      for (let block = 0; block < data.count; block++) {
        if (vec.length(way(block)) === 0) continue;
        for (let p = 3 * first[block]; p < 3 * first[block + 1]; p += 3) {
          places.push(...vec.add(point.subarray(p, p + 3), way(block)));
        }
      }
      continue;
    }
    someCorners((p, block) => {
      const c = middle(block);
      const turn = motion.subarray(6 * block + 3, 6 * block + 6);
      const arm = turned(vec.sub(p, c), turn);
      places.push(...vec.add(vec.add(c, way(block)), arm));
    });
  }
  return places;
}

// Both ends of the arrows that are shown, and where a motion that plays carries those of its blocks; and of lines
// that are no forces, such as the edges that a block had, and marks, such as the base of a robot.
function arrowEnds() {
  const places = [];
  for (const { layers, plays, motion } of data.stages) {
    for (const layer of layers) {
      if (!shown(layer)) continue;
      if (layer.kind === "markers") places.push(...layer.position);
      if (layer.kind === "lines" && !layer.value) {
        for (let i = 0; i < layer.position.length; i += 3) {
          const from = layer.position.subarray(i, i + 3);
          places.push(...from, ...vec.add(from, layer.vector.subarray(i, i + 3)));
        }
      }
      if (layer.kind !== "arrows") continue;
      for (let i = 0; i < layer.position.length; i += 3) {
        const from = layer.position.subarray(i, i + 3);
        const v = vec.scale(layer.vector.subarray(i, i + 3), layer.scale * page.stretch);
        const block = plays && motion && layer.block ? 6 * layer.block[i / 3] : -1;
        for (const share of layer.single ? [-1] : [-0.5, 0.5]) {
          const end = vec.add(from, vec.scale(v, share));
          places.push(...end);
          if (block >= 0) places.push(...vec.add(end, motion.subarray(block, block + 3)));
        }
      }
    }
  }
  return places;
}
