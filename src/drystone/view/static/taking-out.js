// Pictures and tables that leave the page, and printing.

// The picture, twice as fine as on the screen, with head and legend.
function pictureOf(ratio) {
  const { width, height } = sizeOf();
  interrupt();
  const sheet = element("canvas");
  [sheet.width, sheet.height] = [width * ratio, height * ratio];
  const pen = sheet.getContext("2d");
  [canvas.width, canvas.height] = [width * ratio, height * ratio];
  const wasHurried = hurried;
  hurried = false;
  const view = currentView(ratio);
  hurried = wasHurried;
  renderer.draw(view);
  pen.drawImage(canvas, 0, 0);
  const marks = element("canvas");
  [marks.width, marks.height] = [sheet.width, sheet.height];
  drawMarks(marks.getContext("2d"), view, ratio);
  pen.drawImage(marks, 0, 0);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { sheet, pen };
}

function exportPng() {
  const { sheet, pen } = pictureOf(2);
  const { width, height } = sizeOf();
  const marks = captions(data, stage(), theme(), told(), { width, height });
  paintCaptions(pen, marks, markColours().ink, data.ramp[theme()]);
  sheet.toBlob((blob) => download(fileName(data, "png"), blob), "image/png");
  draw();
}

// The picture as SVG, with head, legend and scale.
function linesOf() {
  const [view, size, colours] = [{ ...currentView(), hurried: false }, sizeOf(), markColours()];
  const marks = captions(data, stage(), theme(), { ...told(), ghost: false }, size); // none is drawn there
  const texts = captionsSvg(marks, colours.ink, data.ramp[theme()]) + labelsSvg(view, size, colours);
  return pictureSvg(data, stage(), view, size, theme(), { hidden: page.hidden, captions: texts });
}

// A picture in the colours of paper stands in for the canvas while the page is printed.
function beforePrint() {
  if (!renderer) return;
  page.printing = true;
  page.closed = !byId("details").open;
  byId("details").open = true; // paper cannot be clicked
  refreshPanels();
  if (camera.fits) fit(camera.azimuth, camera.elevation, 0);
  byId("printed").src = pictureOf(2).sheet.toDataURL("image/png");
  byId("printed").hidden = false;
}

function afterPrint() {
  page.printing = false;
  byId("details").open = !page.closed;
  byId("printed").hidden = true;
  refreshPanels();
  if (camera.fits) fit(camera.azimuth, camera.elevation, 0);
}

function connectExports() {
  byId("png").addEventListener("click", exportPng);
  byId("svg").addEventListener("click", () => {
    download(fileName(data, "svg"), linesOf(), "image/svg+xml");
  });
  byId("csv").addEventListener("click", () => {
    download(fileName(data, "csv"), jointsCsv(data, stage()), "text/csv");
  });
  byId("link").addEventListener("click", () => {
    const address = byId("address");
    address.value = `${location.href.split("#")[0]}#${viewText()}`;
    address.hidden = false;
    address.select();
    navigator.clipboard?.writeText(address.value).catch(() => {});
  });
  byId("measure").addEventListener("click", () => setMeasuring(page.measuring === null));
  window.addEventListener("beforeprint", beforePrint);
  window.addEventListener("afterprint", afterPrint);
}
