// The page as a picture to save: its words, the canal, the map and the field.

const [WIDTH, EDGE, LINE] = [1280, 24, 26];

export function savePicture(data, at) {
  const canvas = pictureOf(data, at);
  canvas.toBlob((blob) => {
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: data.picture });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

function pictureOf(data, at) {
  const words = [data.title, at.turning, at.fleet, at.alone, ...at.caveats.children].map((one) => one.textContent ?? one);
  const scale = (element, width) => (element.height / element.width) * width;
  const half = (WIDTH - 3 * EDGE) / 2;
  const canal = Math.min(WIDTH - 2 * EDGE, 700 * (at.canal.width / at.canal.height));
  const top = EDGE + words.length * LINE + 8;
  const below = top + scale(at.canal, canal) + EDGE;
  const height = below + Math.max(scale(at.map, half), scale(at.field, half)) + EDGE;
  const canvas = Object.assign(document.createElement("canvas"), { width: WIDTH, height });
  const pen = canvas.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  pen.fillStyle = style.getPropertyValue("--page");
  pen.fillRect(0, 0, WIDTH, height);
  pen.fillStyle = style.getPropertyValue("--ink");
  words.forEach((text, line) => {
    pen.font = `${line === 1 ? 600 : 400} ${line === 1 ? 19 : 15}px system-ui, sans-serif`;
    pen.fillText(text, EDGE, EDGE + (line + 0.7) * LINE, WIDTH - 2 * EDGE);
  });
  for (const one of [at.canal, at.moving]) pen.drawImage(one, EDGE, top, canal, scale(at.canal, canal));
  pen.drawImage(at.map, EDGE, below, half, scale(at.map, half));
  pen.drawImage(at.field, 2 * EDGE + half, below, half, scale(at.field, half));
  return canvas;
}
