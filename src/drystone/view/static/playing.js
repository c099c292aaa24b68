// What moves by itself: motions and stages.

const STAGE_SECONDS = 1.6;

// Moves what is being played; free fall starts slowly.
function advance(now) {
  if (!animation) return;
  animation.start ??= now;
  const seconds = (now - animation.start) / 1000;
  if (animation.kind === "motion") {
    const share = Math.min(1, seconds / stage().seconds);
    const { arrives, path } = stage();
    setTime(path ? share : arrives ? share * (2 - share) : share * share);
    if (share === 1) stop();
  } else {
    const next = animation.first + Math.floor(seconds / STAGE_SECONDS);
    const last = data.stages.length - 1;
    if (Math.min(next, last) !== page.stage) setStage(Math.min(next, last));
    if (stage().arrives) {
      const share = Math.min(1, (2 * (seconds % STAGE_SECONDS)) / STAGE_SECONDS);
      setTime(next > last ? 1 : share * (2 - share));
    }
    if (next > last) stop();
  }
  if (animation) redraw(true);
}

function stop() {
  animation = null;
  byId("play").textContent = "Play";
  byId("stage-play").textContent = "Play";
}

function play(kind) {
  const again = animation?.kind !== kind;
  stop();
  if (!again || (kind === "motion" && !stage().motion)) return;
  const first = page.stage >= data.stages.length - 1 ? 0 : page.stage;
  animation = { kind, start: null, first };
  byId(kind === "motion" ? "play" : "stage-play").textContent = "Stop";
  redraw();
}

// The positions of the blocks at a share of a path of positions: six numbers a block.
function poseAlong(path, share) {
  const each = 6 * data.count;
  const last = path.length / each - 1;
  const at = Math.min(last, Math.max(0, share * last));
  const i = Math.min(Math.floor(at), Math.max(0, last - 1));
  const [from, to] = [path.subarray(each * i, each * (i + 1)), path.subarray(each * Math.min(i + 1, last))];
  return from.map((x, k) => x + (to[k] - x) * (at - i));
}

function setTime(value) {
  page.time = value;
  const { path, motion } = stage();
  if (path) renderer?.setMotion(value > 0 ? poseAlong(path, value) : motion);
  byId("motion").value = value;
  redraw();
}

function setStage(number) {
  const before = page.stage;
  page.stage = Math.min(data.stages.length - 1, Math.max(0, number));
  setTime(inPlace());
  // What falls has no forces to show: it is solid, and plays once.
  const due = stage().plays ? "solid" : "forces";
  if (page.wanted === "forces" && page.preset !== due) applyPreset(due);
  if (before !== page.stage && stage().plays && !still.matches && !animation) play("motion");
  renderer?.setStage(stage(), page.hidden);
  camera.upward = stage().up;
  byId("stage").value = page.stage;
  const numbered = data.stages.some((one) => one.arrives); // by the number of the step
  byId("stage-label").textContent = numbered
    ? stage().label : `${page.stage + 1} of ${data.stages.length}: ${stage().label}`;
  for (const row of document.querySelectorAll("[data-stage]")) {
    row.setAttribute("aria-pressed", String(Number(row.dataset.stage) === page.stage));
  }
  byId("motion-box").hidden = !stage().motion;
  byId("motion-name").textContent = stage().motionName;
  byId("scale-box").hidden = !stage().layers.some((layer) => layer.kind === "arrows");
  showHeader(data, stage());
  showWorst(data, stage(), actions);
  refreshPanels();
}

function stepStage(by) {
  stop();
  setStage(page.stage + by);
}
