// Lists of the strip: what was changed, load cases, mends, the plan.

let cases = []; // { name, state, headline, verdict }

// Supports, blocks that are out, and pushes, each with a button that takes it back.
function showChanges() {
  const box = byId("live-changes");
  box.replaceChildren();
  const row = (text, title, ...more) => {
    const line = element("div", undefined, { class: "row" });
    line.append(element("span", text, { class: "name", title }), ...more);
    box.append(line);
  };
  const own = factsNow().supports;
  const fixed = supportsNow();
  for (const name of fixed.filter((one) => !own.includes(one))) {
    row(`${name} is a support`, name, button("Free", () => toggleSupport(name)));
  }
  for (const name of own.filter((one) => !fixed.includes(one))) {
    row(`${name} is free`, name, button("Fix", () => toggleSupport(name)));
  }
  for (const name of now.removed) row(`${name} is out`, name, button("Put back", () => putBack(name)));
  for (const { block, force } of now.pushes) {
    const size = vec.length(force);
    const [unit, newton] = size < 1000 ? ["N", 1] : ["kN", 1000];
    const input = element("input", undefined, {
      type: "number", step: "any", min: 0, value: Number((size / newton).toPrecision(4)),
      "aria-label": `Force on ${block} in ${unit}`,
    });
    input.addEventListener("change", () => {
      const wanted = Number(input.value) * newton;
      if (!(wanted >= 0)) return complain(`a force of ${input.value} ${unit} cannot be: give zero or more`);
      return change({ pushes: pushed(block, vec.scale(force, wanted / size)) });
    });
    row(`${block} pushed`, `towards ${directionText(force)}`, input, element("span", unit),
      button("\u00d7", () => change({ pushes: pushed(block, [0, 0, 0]) }), { "aria-label": "No force" }));
  }
  for (const { block, by } of now.moves) {
    row(`${block} moved by`, block,
      button("\u00d7", () => change({ moves: moved(block, [0, 0, 0]) }), { "aria-label": "Not moved" }));
    const line = element("div", undefined, { class: "way" });
    by.forEach((way, i) => {
      const input = element("input", undefined, {
        type: "number", step: "any", value: Number((1000 * way).toPrecision(4)),
        "aria-label": `${block} moved along ${"xyz"[i]} in mm`,
      });
      input.addEventListener("change", () => {
        const wanted = by.map((old, k) => (k === i ? Number(input.value) / 1000 : old));
        change({ moves: moved(block, wanted) });
      });
      line.append(element("span", "xyz"[i]), input);
    });
    line.append(element("span", "mm"));
    box.append(line);
  }
}

// What a load case has that the file has not.
function describe(state) {
  const { supports } = models.get(state.model) ?? { supports: [] };
  const changed = state.supports
    ? [...state.supports, ...supports].filter((one) => state.supports.includes(one) !== supports.includes(one)).length
    : 0;
  const count = (n, one, many) => (n ? `${n} ${n === 1 ? one : many}` : "");
  const parts = [
    state.tilt ? `tilt ${state.tilt}\u00b0 towards ${state.direction}\u00b0` : "",
    state.friction === null ? "" : `friction ${state.friction}`,
    state.gravity === null ? "" : `gravity ${state.gravity} m/s\u00b2`,
    count(changed, "support changed", "supports changed"),
    count(state.removed.length, "block out", "blocks out"),
    count(state.pushes.length, "push", "pushes"),
    count(state.moves.length, "support moved", "supports moved"),
  ].filter(Boolean);
  return parts.join(", ") || "as in the file";
}

function showCases() {
  const table = byId("cases");
  table.replaceChildren();
  byId("cases-check").hidden = cases.length === 0;
  for (const one of cases) {
    const line = table.insertRow();
    line.insertCell().append(button(one.name, () => {
      past.states = [...past.states.slice(0, past.at + 1), one.state];
      past.at = past.states.length - 1;
      goTo(one.state);
    }, { title: "Show this load case" }));
    const told = line.insertCell();
    told.append(element("span", one.headline), element("small", describe(one.state)));
    told.className = one.verdict;
    line.insertCell().append(button("\u00d7", () => {
      cases = cases.filter((other) => other !== one);
      showCases();
    }, { "aria-label": `Forget ${one.name}` }));
  }
}

function keepCase(name) {
  const told = wholeAnswer?.state === now ? wholeAnswer : { headline: "is being checked", verdict: "" };
  cases = cases.filter((one) => one.name !== name);
  cases.push({ name, state: now, headline: told.headline, verdict: told.verdict });
  showCases();
  if (told !== wholeAnswer) checkCases();
}

// Those of the model that is shown.
function checkCases() {
  const listed = cases.filter((one) => one.state.model === now.model);
  checking = listed;
  if (listed.length) task("cases", { cases: listed.map((one) => wishOf(one.state)) });
}
let checking = [];
let wholeAnswer = null; // { state, headline, verdict }

function hearCase({ number, headline, verdict }) {
  if (!checking[number]) return;
  Object.assign(checking[number], { headline, verdict });
  showCases();
}

// A mend that stands, while others are being looked for.
function showMend(mend, number) {
  const made = button(mend.what, () => {
    showGhostOf(null);
    task("apply", { mend: number });
  }, { title: mend.blocks.join(", ") });
  made.append(" ", element("small", `for ${someOf(mend.blocks)} (${mend.price})`));
  for (const event of ["pointerenter", "focus"]) made.addEventListener(event, () => showGhostOf(mend.ghost));
  for (const event of ["pointerleave", "blur"]) made.addEventListener(event, () => showGhostOf(null));
  byId("mends").append(made);
}

// All of them, the cheapest of a region first.
function showMends({ mends, tried, message, stopped }) {
  const box = byId("mends");
  showGhostOf(null);
  box.replaceChildren();
  for (const mend of mends) showMend(mend, mend.number);
  const words = [message, stopped ? "the search was stopped before all was tried" : ""].filter(Boolean);
  if (!mends.length && !words.length) words.push("no mend was found");
  for (const text of words) box.append(element("p", text));
  if (!tried.length) return;
  const failed = element("details");
  failed.append(element("summary", `${tried.length} tried without success`));
  for (const { blocks, what } of tried) {
    failed.append(element("p", `${someOf(blocks)}: ${what}`, { title: blocks.join(", ") }));
  }
  box.append(failed);
}

const someOf = (names) => (names.length > 3
  ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", "));

// A mend was made: its model is the one to ask about from now on.
async function mended({ model, facts, what, state }) {
  models.set(model, facts);
  busy(false);
  await showModel(model);
  change({ ...plainState(model), ...state });
  byId("mends").replaceChildren(element("p", `made: ${what}`));
}

let order = [];
let orderHelp = {}; // what each block of the order that was checked needs

function showPlanAnswer({ plan, scene }) {
  const box = byId("plan");
  box.replaceChildren();
  order = [...plan.order];
  orderHelp = plan.help;
  const counts = Object.entries(plan.counts).filter(([, n]) => n > 0).map(([kind, n]) => `${n} ${kind}`);
  const words = [plan.stopped, plan.message, counts.join(", ")];
  if (plan.asked.length && plan.asked.join("\n") !== plan.order.join("\n")) {
    words.push("the order that was asked for cannot be followed everywhere; this one is nearest");
  }
  for (const text of words.filter(Boolean)) box.append(element("p", text));
  for (const [name, why] of Object.entries(plan.impossible)) box.append(element("p", `${name}: ${why}`));
  if (order.length) {
    box.append(element("ol"), button("Check this order", () => task("plan", { order })));
    showOrder();
  }
  if (scene) showPlan(scene);
}

function showOrder() {
  const list = byId("plan").querySelector("ol");
  list.replaceChildren();
  order.forEach((name, i) => {
    const line = element("div", undefined, { class: "row" });
    const move = (by) => {
      [order[i], order[i + by]] = [order[i + by], order[i]];
      orderHelp = {};
      showOrder();
    };
    line.append(element("span", name, { class: "name", title: name }));
    if (orderHelp[name]) line.append(element("small", orderHelp[name]));
    const up = button("\u2191", () => move(-1), { "aria-label": `${name} earlier` });
    const down = button("\u2193", () => move(1), { "aria-label": `${name} later` });
    [up.disabled, down.disabled] = [i === 0, i === order.length - 1];
    line.append(up, down);
    const item = element("li");
    item.append(line);
    list.append(item);
  });
}
