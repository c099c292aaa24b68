// What the window asks for, what it asked for before, and sending it: one wish at a time.

const IMPATIENT = 600; // [ms] without a quick answer after which a newer wish is sent all the same
const LONGEST_HISTORY = 200;

const begins = JSON.parse(byId("live-begins").textContent);
const models = new Map([[begins.model, begins.facts]]);

const plainState = (model) => ({
  model, tilt: 0, direction: 0, friction: null, gravity: null, supports: null, removed: [], pushes: [],
  moves: [],
});

let now = plainState(begins.model); // what the controls say
let stood = now; // the last of them that was answered
const past = { states: [now], at: 0 };
let dirty = false;
let sentAt = 0;

const factsNow = () => models.get(now.model);
const wishOf = ({ model, ...wish }) => wish;
const supportsNow = () => now.supports ?? factsNow().supports;

// Changes the state; `keep` makes it a step of undo.
function change(parts, keep = true) {
  if (planShown()) leavePlan();
  forgetFound(parts);
  now = { ...now, ...parts };
  if (keep) {
    past.states = [...past.states.slice(0, past.at + 1), now].slice(-LONGEST_HISTORY);
    past.at = past.states.length - 1;
  }
  showControls();
  send();
}

// What was found for another load case: mends, the plan, and the edge unless only the tilt has changed.
function forgetFound(parts) {
  byId("mends").replaceChildren();
  byId("plan").replaceChildren();
  const ofTheEdge = Object.keys(parts).every((key) => key === "tilt" || key === "direction");
  if (!ofTheEdge) byId("edge-answer").replaceChildren();
}

function step(by) {
  const to = past.at + by;
  if (to < 0 || to >= past.states.length) return;
  past.at = to;
  goTo(past.states[to]);
}

// Shows another state, with the model that it is about.
async function goTo(state) {
  if (state.model !== now.model || planShown()) {
    try {
      await showModel(state.model);
    } catch (error) {
      complain(error.message);
      return;
    }
  }
  now = state;
  forgetFound(now);
  showControls();
  send();
}

// What cannot be is not kept: the controls show the last state that was answered, which is asked for again.
function refuse(text) {
  complain(text);
  if (now === stood || now !== live.asked || stood.model !== now.model) return;
  past.states = past.states.filter((one) => one !== now);
  past.at = Math.min(past.at, past.states.length - 1);
  now = stood;
  showControls();
  send(text);
}

// The next wish waits for the quick answer to the one before, but not for ever. `trouble` stays to be read.
async function send(trouble = "") {
  dirty = true;
  const waited = performance.now() - sentAt;
  if (live.waiting && waited < IMPATIENT) {
    setTimeout(() => dirty && send(), IMPATIENT - waited + 1);
    return;
  }
  dirty = false;
  live.number += 1;
  const number = live.number;
  Object.assign(live, { waiting: number, wish: number, asked: now });
  sentAt = performance.now();
  if (!byId("task-stop").hidden) busy(false, "stopped by the new load case");
  live.sending = ask("/live/wish", { window: live.window, number, model: now.model, wish: wishOf(now) });
  try {
    await live.sending;
    complain(trouble);
  } catch (error) {
    answered(number);
    if (error.refused && number === live.wish) refuse(error.message);
    else complain(error.message);
  }
}

function answered(number) {
  if (number < live.waiting) return;
  live.waiting = 0;
  if (dirty) send();
}

// A wish that is on its way arrives first: it would end the task.
async function task(name, extra = {}, state = now) {
  if (name !== "cases") busy(true);
  try {
    await live.sending.catch(() => {});
    live.number += 1;
    const body = { window: live.window, number: live.number, model: state.model, task: name, extra };
    await ask("/live/task", { ...body, wish: wishOf(state) });
  } catch (error) {
    busy(false);
    complain(error.message);
  }
}

function complain(text) {
  byId("live-trouble").hidden = text === "" && !broken;
  byId("live-trouble").textContent = [broken, text].filter(Boolean).join("\n");
}
let broken = ""; // why the file cannot be read
