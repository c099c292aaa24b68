// A page in a notebook with sliders: an anywidget module.

function sliderOf(model, { name, least, most, step }) {
  const row = document.createElement("label");
  row.style.cssText = "display:flex;gap:.6em;align-items:center;font:13px system-ui,sans-serif";
  const slider = document.createElement("input");
  Object.assign(slider, { type: "range", min: least, max: most, step, value: model.get("values")[name] });
  slider.style.flex = "1";
  const told = document.createElement("output");
  const tell = (value) => { told.textContent = Number(Number(value).toPrecision(4)); };
  tell(model.get("values")[name]); // the slider itself stands at the nearest step
  slider.addEventListener("input", () => tell(slider.value));
  slider.addEventListener("change", () => {
    model.set("values", { ...model.get("values"), [name]: Number(slider.value) });
    model.save_changes();
  });
  model.on("change:values", () => {
    slider.value = model.get("values")[name];
    tell(model.get("values")[name]);
  });
  row.append(document.createTextNode(name), slider, told);
  return row;
}

function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.setAttribute("sandbox", "allow-scripts allow-downloads");
  frame.title = "drystone";
  frame.style.cssText = `width:100%;height:${model.get("height")}px;border:0`;
  const trouble = document.createElement("p");
  trouble.setAttribute("role", "alert");
  trouble.style.cssText = "color:#b3261e;font:13px system-ui,sans-serif;margin:.4em 0";
  let view = "";
  let restored = "";
  let hearing = false;
  const say = (message) => frame.contentWindow?.postMessage(message, "*");
  const show = () => {
    restored = view;
    frame.srcdoc = model.get("page");
  };
  const heard = ({ source, data }) => {
    if (source !== frame.contentWindow || data?.drystone !== "state") return;
    if (restored) { // a new page: from where one looked at the one before
      say({ drystone: "view", view: restored });
      restored = "";
      return;
    }
    view = data.view;
    hearing = true; // what the page says is not said back to it: it may have changed meanwhile
    model.set("picked", model.get("names")[data.block] ?? "");
    model.set("picked_joint", data.joint);
    hearing = false;
    model.save_changes();
  };
  const pick = () => hearing || say({ drystone: "pick", block: model.get("names").indexOf(model.get("picked")) });
  const tell = () => { trouble.textContent = model.get("trouble"); };
  window.addEventListener("message", heard);
  model.on("change:page", show);
  model.on("change:picked", pick);
  model.on("change:trouble", tell);
  el.append(...model.get("sliders").map((one) => sliderOf(model, one)), trouble, frame);
  show();
  tell();
  return () => window.removeEventListener("message", heard);
}

export default { render };
