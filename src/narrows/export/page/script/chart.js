// A picture of cells with axes: offsets from bank to bank upwards or downwards, something else across.

const ROOM = { left: 44, right: 10, top: 6, bottom: 36 };
const STEPS = [1, 2, 5, 10];

/** `across` is {range, label}; offsets run from port, at the top, to starboard. */
export function chart(canvas, height, across, width, colours) {
  const pen = canvas.getContext("2d");
  const ratio = globalThis.devicePixelRatio || 1;
  canvas.style.height = `${height}px`;
  Object.assign(canvas, { width: Math.round(canvas.clientWidth * ratio), height: Math.round(height * ratio) });
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  const box = { left: ROOM.left, top: ROOM.top, right: canvas.clientWidth - ROOM.right, bottom: height - ROOM.bottom };
  const [low, high] = across.range;
  const toX = (value) => box.left + (value - low) / (high - low) * (box.right - box.left);
  const toY = (y) => (box.top + box.bottom) / 2 + y / width * (box.bottom - box.top);

  function axes() {
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = colours.soft;
    pen.textBaseline = "alphabetic";
    pen.textAlign = "center";
    for (const value of marks(low, high, 7)) pen.fillText(plain(value), toX(value), box.bottom + 15);
    pen.fillText(across.label, (box.left + box.right) / 2, box.bottom + 31);
    pen.textAlign = "right";
    for (const y of marks(-width / 2, width / 2, 7)) pen.fillText(plain(Math.abs(y)), box.left - 6, toY(y) + 4);
    pen.save();
    pen.translate(11, (box.top + box.bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText("← starboard  m  port →", 0, 0);
    pen.restore();
  }

  /** Square pictures of cells, row by row from port. */
  function cells(pixels, columns, rows) {
    const small = document.createElement("canvas");
    Object.assign(small, { width: columns, height: rows });
    small.getContext("2d").putImageData(new ImageData(pixels, columns, rows), 0, 0);
    pen.imageSmoothingEnabled = true;
    pen.drawImage(small, box.left, box.top, box.right - box.left, box.bottom - box.top);
  }

  function clipped(paint) {
    pen.save();
    pen.beginPath();
    pen.rect(box.left, box.top, box.right - box.left, box.bottom - box.top);
    pen.clip();
    paint(pen);
    pen.restore();
  }

  function line(points, style) {
    clipped(() => {
      pen.beginPath();
      points.forEach(([value, y], place) => pen[place ? "lineTo" : "moveTo"](toX(value), toY(y)));
      Object.assign(pen, { strokeStyle: style.stroke, lineWidth: style.width ?? 1.5 });
      pen.setLineDash(style.dash ?? []);
      pen.stroke();
      pen.setLineDash([]);
    });
  }

  function marker(value, y) {
    line([[value, -width], [value, width]], { stroke: colours.ink, width: 0.75 });
    line([[low, y], [high, y]], { stroke: colours.ink, width: 0.75 });
    pen.beginPath();
    pen.arc(toX(value), toY(y), 6, 0, 7);
    Object.assign(pen, { fillStyle: colours.ink, strokeStyle: colours.panel, lineWidth: 2 });
    pen.fill();
    pen.stroke();
  }

  /** What lies under a point of the canvas: [value across, offset]. */
  function under(x, y) {
    const share = Math.min(1, Math.max(0, (x - box.left) / (box.right - box.left)));
    const down = Math.min(1, Math.max(0, (y - box.top) / (box.bottom - box.top)));
    return [low + share * (high - low), (down - 0.5) * width];
  }
  return { axes, cells, line, marker, under, box };
}

const plain = (value) => String(+value.toPrecision(4));

function marks(low, high, most) {
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const step = power * STEPS.find((one) => (high - low) / (one * power) <= most);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, place) => (first + place) * step);
}
