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

function setMode(wanted) {
  canvas.classList.remove(`live-${mode}`);
  mode = wanted;
  canvas.classList.add(`live-${mode}`);
  page.onlyBlocks = DOES[mode] ? (block) => `${nameOf(block)}: ${DOES[mode](block)}` : null;
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

let drag = null; // { block, pointer, x, y, before, from }
const SVG_ARROW = '<svg id="push-arrow" hidden><line/><text/></svg>';

function showArrow(event, words) {
  const box = canvas.getBoundingClientRect();
  const [line, text] = byId("push-arrow").children;
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const ends = { x1: drag.x - box.left, y1: drag.y - box.top, x2: x, y2: y };
  for (const [key, value] of Object.entries(ends)) line.setAttribute(key, value);
  text.setAttribute("x", Math.min(x + 12, box.width - 90));
  text.setAttribute("y", Math.max(y - 8, 16));
  text.textContent = words;
}

const inKilonewton = (force) => `${Number((vec.length(force) / 1000).toPrecision(3))} kN`;

function pressed(event) {
  if (mode === "look" || planShown() || event.button !== 0 || event.shiftKey || event.target !== canvas) return;
  const { block } = under(event);
  if (block === undefined) return; // beside the blocks one still turns the model
  event.stopImmediatePropagation();
  event.preventDefault();
  hovered(null);
  if (mode === "support") toggleSupport(nameOf(block));
  else if (mode === "remove") takeOut(nameOf(block));
  else if (supportsNow().includes(nameOf(block)) !== (mode === "move")) {
    complain(mode === "move" ? `${nameOf(block)} is no support: make it one, or push it`
      : `${nameOf(block)} is a support: a force on it changes nothing`);
  } else {
    const [before, from] = [now, movedBy(nameOf(block))];
    drag = { block, pointer: event.pointerId, x: event.clientX, y: event.clientY, before, from };
    canvas.setPointerCapture(event.pointerId);
    byId("push-arrow").removeAttribute("hidden");
    showArrow(event, "");
  }
}

function dragged(event) {
  if (!drag || event.pointerId !== drag.pointer) return;
  event.stopImmediatePropagation();
  const [dx, dy] = [event.clientX - drag.x, event.clientY - drag.y];
  const name = nameOf(drag.block);
  if (mode === "move") {
    const by = wayOf(drag.from, dx, dy);
    showArrow(event, quantity(vec.length(by), "m"));
    change({ moves: moved(name, by) }, false);
  } else {
    const force = forceOf(drag.block, dx, dy);
    showArrow(event, inKilonewton(force));
    change({ pushes: pushed(name, force) }, false);
  }
}

function released(event) {
  if (!drag || event.pointerId !== drag.pointer) return;
  event.stopImmediatePropagation();
  const { before } = drag;
  drag = null;
  byId("push-arrow").setAttribute("hidden", "");
  const { pushes, moves } = event.type === "pointerup" ? now : before;
  change({ pushes, moves });
}

function connectPush() {
  const holder = canvas.parentElement;
  holder.insertAdjacentHTML("beforeend", SVG_ARROW);
  holder.addEventListener("pointerdown", pressed, true);
  holder.addEventListener("pointermove", dragged, true);
  holder.addEventListener("pointerup", released, true);
  holder.addEventListener("pointercancel", released, true);
  for (const one of byId("modes").children) {
    one.addEventListener("click", () => setMode(one.dataset.mode));
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
