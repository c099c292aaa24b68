// Talks to the notebook around the page, where there is one: what is picked, and from where one looks.

const around = window.parent === window ? null : window.parent;

function tellAround() {
  if (!around) return;
  around.postMessage({ drystone: "state", block: page.selected, joint: page.joint, view: viewText() }, "*");
}

function hearAround(event) {
  const said = event.data;
  if (event.source !== around || typeof said !== "object" || said === null) return;
  if (said.drystone === "view" && typeof said.view === "string") readView(said.view);
  const block = said.block;
  if (said.drystone === "pick" && Number.isInteger(block) && block >= -1 && block < data.count) {
    if (block !== page.selected) actions.select(block);
  }
}

function connectAround() {
  if (!around) return;
  window.addEventListener("message", hearAround);
  for (const kind of ["pointerup", "keyup", "wheel", "click", "input"]) {
    document.addEventListener(kind, () => setTimeout(tellAround, 0), { passive: true });
  }
  tellAround();
}
