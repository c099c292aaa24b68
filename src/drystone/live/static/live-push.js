// Clicks and drags on blocks, where they change something instead of looking.

const MODE_HELP = {
  look: "Opens the card of a block or joint.",
  support: "Makes a block a support, or frees it.",
  remove: "Takes a block out. It can be put back below.",
  push: "Drag a free block: the arrow is the force. As long as the block is its weight.",
  move: "Drag a support: it moves as far as you drag, and the blocks follow.",
};
// What a click or a drag on a block does, for the text beside the pointer.
const DOES = {
  support: (block) => (supportsNow().includes(nameOf(block)) ? "a click frees it" : "a click makes it a support"),
  remove: () => "a click takes it out",
  push: (block) => (supportsNow().includes(nameOf(block)) ? "a support: not pushed" : "drag to push it"),
  move: (block) => (supportsNow().includes(nameOf(block)) ? "drag to move it" : "no support: not moved"),
};
let mode = "look";
const drags = () => mode === "push" || mode === "move";

function setMode(wanted) {
  canvas.classList.remove(`live-${mode}`);
  mode = wanted;
  canvas.classList.add(`live-${mode}`);
  const says = (block) => `${nameOf(block)}: ${DOES[mode](block)}`;
  page.acts = DOES[mode] ? { says, clicked: clickedBlock, grabbed: grabbedBlock } : null;
  byId("mode-help").textContent = MODE_HELP[mode];
  for (const one of byId("modes").children) {
    one.setAttribute("aria-pressed", String(one.dataset.mode === mode));
  }
}

const nameOf = (block) => data.blocks.names[block];

function toggleSupport(name) {
  const fixed = supportsNow();
  const supports = fixed.includes(name) ? fixed.filter((one) => one !== name) : [...fixed, name];
  change({
    supports, pushes: now.pushes.filter((one) => !supports.includes(one.block)),
    moves: now.moves.filter((one) => supports.includes(one.block)),
  });
}

function takeOut(name) {
  if (now.removed.includes(name)) return; // the picture still has it
  change({
    removed: [...now.removed, name], pushes: pushed(name, [0, 0, 0]), moves: moved(name, [0, 0, 0]),
  });
  actions.select(-1);
}

function putBack(name) {
  change({ removed: now.removed.filter((one) => one !== name) });
}

function pushed(name, force) {
  const others = now.pushes.filter((one) => one.block !== name);
  return vec.length(force) > 0 ? [...others, { block: name, force }] : others;
}

function moved(name, by) {
  const others = now.moves.filter((one) => one.block !== name);
  return vec.length(by) > 0 ? [...others, { block: name, by }] : others;
}

const movedBy = (name) => now.moves.find((one) => one.block === name)?.by ?? [0, 0, 0];

// How far [m] a support has moved after a drag by pixels, beside `from` where it was moved to before.
function wayOf(from, dx, dy) {
  const { metresPerPixel, right, up } = currentView();
  const drawn = vec.add(vec.scale(right, dx * metresPerPixel), vec.scale(up, -dy * metresPerPixel));
  return vec.add(from, drawn).map((x) => Number(x.toPrecision(4)));
}

// The force [N] in space of a drag by pixels: a drag as long as the block is its weight.
function forceOf(block, dx, dy) {
  const { metresPerPixel, right, up } = currentView();
  const weight = data.blocks.mass[block] * (now.gravity || factsNow().gravity || 9.81);
  const scale = (weight * metresPerPixel) / data.blockSize;
  const inModel = vec.add(vec.scale(right, dx * scale), vec.scale(up, -dy * scale));
  return turnedBetween(inModel, stage().up, [0, 0, 1]).map((x) => Number(x.toPrecision(4)));
}

const SVG_ARROW = '<svg id="push-arrow" hidden><line/><text/></svg>';

// From where one pressed to where one is.
function showArrow(start, event, words) {
  const box = canvas.getBoundingClientRect();
  const [line, text] = byId("push-arrow").children;
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const ends = { x1: start.clientX - box.left, y1: start.clientY - box.top, x2: x, y2: y };
  for (const [key, value] of Object.entries(ends)) line.setAttribute(key, value);
  text.setAttribute("x", Math.min(x + 12, box.width - 90));
  text.setAttribute("y", Math.max(y - 8, 16));
  text.textContent = words;
}

// A drag of a block from a press to where it is let go; where it does not count all is as it was.
function dragOf(block, start) {
  const [before, name] = [now, nameOf(block)];
  const from = movedBy(name);
  const move = (event) => {
    const [dx, dy] = [event.clientX - start.clientX, event.clientY - start.clientY];
    byId("push-arrow").removeAttribute("hidden");
    if (mode === "move") {
      const by = wayOf(from, dx, dy);
      showArrow(start, event, quantity(vec.length(by), "m"));
      change({ moves: moved(name, by) }, false);
    } else {
      const force = forceOf(block, dx, dy);
      showArrow(start, event, quantity(vec.length(force), "N"));
      change({ pushes: pushed(name, force) }, false);
    }
  };
  const end = (counts) => {
    byId("push-arrow").setAttribute("hidden", "");
    if (counts) change({});
    else if (now !== before) goTo(before);
  };
  return { move, end };
}

// The press that drags a block. One that cannot be dragged says so, and does not turn the model.
function grabbedBlock(block, event) {
  if (!drags()) return null;
  if (supportsNow().includes(nameOf(block)) === (mode === "move")) return dragOf(block, event);
  hovered(event);
  return { move() {}, end() {} };
}

const DOUBLE = 400; // [ms] between the clicks of a double click, at most
let acted = null; // the last click that changed something

function isSecond({ timeStamp, clientX, clientY }) {
  if (!acted || timeStamp - acted.timeStamp > DOUBLE) return false;
  return Math.hypot(clientX - acted.clientX, clientY - acted.clientY) < NEAR_JOINT;
}

function clickedBlock(block, event) {
  if (drags()) actions.select(block); // its card does the same without a drag
  else if (isSecond(event)) return; // of a double click the first does it
  else if (mode === "support") toggleSupport(nameOf(block));
  else takeOut(nameOf(block));
  acted = event;
}

function connectPush() {
  canvas.parentElement.insertAdjacentHTML("beforeend", SVG_ARROW);
  for (const one of byId("modes").children) {
    one.addEventListener("click", () => {
      leavePlan();
      setMode(one.dataset.mode);
    });
  }
  setMode("look");
  const { select } = actions;
  actions.select = (block) => {
    select(block);
    showBlockActions();
  };
}

// Buttons for the block that is selected: the same without a mouse.
function showBlockActions() {
  const box = byId("block-actions");
  box.replaceChildren();
  box.hidden = page.selected < 0 || planShown();
  if (box.hidden) return;
  const name = nameOf(page.selected);
  const fixed = supportsNow().includes(name);
  box.append(
    element("p", `Block ${name}`),
    button(fixed ? "Free it" : "Make it a support", () => toggleSupport(name)),
    button("Take it out", () => takeOut(name)),
  );
  if (fixed) {
    const down = -Number((0.05 * data.blockSize).toPrecision(1));
    if (vec.length(movedBy(name)) === 0) {
      box.append(button("Move it", () => change({ moves: moved(name, [0, 0, down]) })));
    }
    return;
  }
  box.append(button("Cut it in two", () => task("cut", { block: name }), {
    title: "By a level plane through its centre of mass",
  }));
  box.append(button("Push it", () => {
    const weight = data.blocks.mass[page.selected] * (factsNow().gravity || 9.81);
    change({ pushes: pushed(name, [Number((0.1 * weight).toPrecision(2)), 0, 0]) });
  }));
}
