// Head, legend and scale of an exported picture, as marks that pixels and lines draw alike.

const CAPTION_FONT = "system-ui, sans-serif";
const ROW = 18; // [CSS pixels] from one row of the legend to the next

const fontOf = ({ size = 12, bold = false }) => `${bold ? "600 " : ""}${size}px ${CAPTION_FONT}`;

// The lines of a text that is at most `width` wide.
function wrapped(pen, text, width) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = lines.at(-1) ? `${lines.at(-1)} ${word}` : word;
    if (!lines.at(-1) || pen.measureText(longer).width <= width) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

// Marks: texts from their upper left corner, colour bars, and the swatches of the legend.
function captions(data, stage, theme, told, { width, height }) {
  const pen = element("canvas").getContext("2d");
  const marks = [];
  let y = 14;
  for (const [words, look] of [
    [stage.headline || data.title, { size: 18, bold: true }], [stage.asked, { size: 12 }],
  ]) {
    pen.font = fontOf(look);
    for (const line of wrapped(pen, words, width - 32)) {
      marks.push({ words: line, x: 16, y, ...look });
      y += 1.4 * look.size;
    }
  }
  const rows = legendRows(data, stage, theme, told);
  y = height - ROW * rows.length - 10;
  for (const row of rows) {
    if (row.bar) {
      const [least, , most] = barTexts(row.bar);
      marks.push({ bar: true, x: 16, y: y + 1, width: 120, height: 11 });
      marks.push({ words: `${row.text}: ${least} to ${most}`, x: 144, y });
    } else {
      marks.push({ shape: row.shape, colour: row.colour, x: 16, y: y + 1 });
      marks.push({ words: row.text, x: 40, y });
    }
    y += ROW;
  }
  return marks;
}

// The outline of a swatch, as corners; a disc has none.
function swatchCorners({ shape, x, y }) {
  const box = (x0, y0, x1, y1) => [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
  if (shape === "arrow") {
    return [[0, 4.5], [10, 4.5], [10, 1], [16, 6], [10, 11], [10, 7.5], [0, 7.5]].map(([dx, dy]) => [x + dx, y + dy]);
  }
  if (shape === "thick" || shape === "dashed") return box(x, y + 4, x + 16, y + 8);
  if (shape === "diamond") return [[x + 8, y], [x + 14, y + 6], [x + 8, y + 12], [x + 2, y + 6]];
  return box(x, y, x + 16, y + 12);
}

const HATCH = "#d55e00";
const OUTLINE = 0.5; // [CSS pixels]
const isBox = ({ shape }) => shape === "" || shape === "hatch"; // glassy blocks are almost white
const hatchLines = ({ x, y }) => [0, 5, 10].map((k) => [[x + k, y + 12], [x + k + 6, y]]);

function paintCaptions(pen, marks, ink, stops) {
  pen.textAlign = "left";
  pen.textBaseline = "top";
  const along = (points) => {
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
  };
  for (const mark of marks) {
    pen.fillStyle = mark.colour ?? ink;
    if (mark.words !== undefined) {
      pen.font = fontOf(mark);
      pen.fillText(mark.words, mark.x, mark.y);
    } else if (mark.bar) {
      const fill = pen.createLinearGradient(mark.x, 0, mark.x + mark.width, 0);
      stops.forEach((stop, i) => fill.addColorStop(i / (stops.length - 1), stop));
      pen.fillStyle = fill;
      pen.fillRect(mark.x, mark.y, mark.width, mark.height);
    } else {
      if (mark.shape === "disc") {
        pen.beginPath();
        pen.arc(mark.x + 8, mark.y + 6, 5, 0, 7);
      } else along(swatchCorners(mark));
      pen.fill();
    }
    if (isBox(mark)) {
      along([...swatchCorners(mark), [mark.x, mark.y]]);
      pen.strokeStyle = ink;
      pen.lineWidth = OUTLINE;
      pen.stroke();
      pen.lineWidth = 1;
    }
    pen.strokeStyle = HATCH;
    for (const line of mark.shape === "hatch" ? hatchLines(mark) : []) {
      along(line);
      pen.stroke();
    }
  }
}

function captionsSvg(marks, ink, stops) {
  const points = (corners) => corners.map((p) => p.join()).join(" ");
  const parts = [];
  for (const mark of marks) {
    const { x, y, size = 12, bold = false } = mark;
    if (mark.words !== undefined) {
      parts.push(`<text x="${x}" y="${y + 0.85 * size}" font-family="${CAPTION_FONT}" font-size="${size}" `
        + `font-weight="${bold ? 600 : 400}" fill="${ink}">${escapeXml(mark.words)}</text>`);
    } else if (mark.bar) {
      const step = mark.width / stops.length;
      parts.push(...stops.map((stop, i) => `<rect x="${(x + i * step).toFixed(2)}" y="${y}" `
        + `width="${(step + 0.1).toFixed(2)}" height="${mark.height}" fill="${stop}"/>`));
    } else if (mark.shape === "disc") {
      parts.push(`<circle cx="${x + 8}" cy="${y + 6}" r="5" fill="${mark.colour}"/>`);
    } else {
      const outline = isBox(mark) ? ` stroke="${ink}" stroke-width="${OUTLINE}"` : "";
      parts.push(`<polygon points="${points(swatchCorners(mark))}" fill="${mark.colour}"${outline}/>`);
    }
    for (const line of mark.shape === "hatch" ? hatchLines(mark) : []) {
      parts.push(`<polyline points="${points(line)}" stroke="${HATCH}" fill="none"/>`);
    }
  }
  return parts.join("");
}

// The scale bar, and the names and numbers of blocks, as on the screen.
function labelsSvg(view, size, { ink, paper }) {
  const { pixels, text } = scaleBar(view.metresPerPixel);
  const [x, y] = [size.width - pixels - 24, size.height - 16];
  const word = (words, at, up) => `<text x="${at.toFixed(1)}" y="${up.toFixed(1)}" text-anchor="middle" `
    + `font-family="${CAPTION_FONT}" font-size="11" fill="${ink}" stroke="${paper}" stroke-width="3" `
    + `paint-order="stroke">${escapeXml(words)}</text>`;
  const parts = [
    `<path d="M${x} ${y - 4}V${y}H${x + pixels}V${y - 4}" fill="none" stroke="${ink}" stroke-width="2"/>`,
    word(text, x + pixels / 2, y - 6),
  ];
  const told = { names: shownLayers.get("names"), numbers: shownLayers.get("numbers"), hidden: page.hidden };
  if (view.time === 0) {
    const pen = element("canvas").getContext("2d");
    pen.font = `11px ${CAPTION_FONT}`;
    const kept = apart(blockLabels(data, stage(), view, size, told), (one) => pen.measureText(one).width, 15);
    parts.push(...kept.map((label) => word(label.text, label.x, label.y + 4)));
  }
  return parts.join("");
}
