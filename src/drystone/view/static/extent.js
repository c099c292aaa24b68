// What a view has to hold: blocks, where they move to, and the arrows of forces.

const MOST_POINTS = 100000; // corners looked at

// Places (three numbers each) with the model taken apart by `spread`.
function placesAt(spread) {
  return new Float32Array([...cornersAt(spread), ...motionEnds(), ...(spread ? [] : arrowEnds())]);
}

// Corners of the blocks, every so-many-th where there are many.
function cornersAt(spread) {
  const { away } = data.blocks;
  const places = [];
  someCorners((p, block) => {
    for (let i = 0; i < 3; i++) places.push(p[i] + spread * away[3 * block + i]);
  });
  return places;
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

// Where a motion that plays by itself leads or the forces of a stage are, and where blocks come from that are placed.
function motionEnds() {
  const places = [];
  const { centroid } = data.blocks;
  const middle = (block) => centroid.subarray(3 * block, 3 * block + 3);
  for (const { arrives, plays, moved, motion } of data.stages) {
    if (!motion || !(arrives || plays || moved)) continue;
    const way = (block) => motion.subarray(6 * block, 6 * block + 3);
    if (arrives) {
      for (let block = 0; block < data.count; block++) {
        if (vec.length(way(block)) === 0) continue;
        places.push(...vec.add(middle(block), vec.scale(way(block), 1.3)));
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

// Both ends of the arrows that are shown.
function arrowEnds() {
  const places = [];
  for (const layer of data.stages.flatMap((one) => one.layers)) {
    if (layer.kind !== "arrows" || !shown(layer)) continue;
    for (let i = 0; i < layer.position.length; i += 3) {
      const from = layer.position.subarray(i, i + 3);
      const v = vec.scale(layer.vector.subarray(i, i + 3), layer.scale * page.stretch);
      const ends = layer.single ? [-1] : [-0.5, 0.5];
      for (const share of ends) places.push(...vec.add(from, vec.scale(v, share)));
    }
  }
  return places;
}
