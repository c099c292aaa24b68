// What moves by itself: motions and stages.

const FALL_SECONDS = 2.4;
const STAGE_SECONDS = 1.6;

// Moves what is being played; free fall starts slowly.
function advance(now) {
  if (!animation) return;
  animation.start ??= now;
  const seconds = (now - animation.start) / 1000;
  if (animation.kind === "motion") {
    const share = Math.min(1, seconds / FALL_SECONDS);
    setTime(stage().arrives ? share * (2 - share) : share * share);
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
  if (animation) redraw();
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

function setTime(value) {
  page.time = value;
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
  byId("stage-label").textContent = `${page.stage + 1} of ${data.stages.length}: ${stage().label}`;
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
