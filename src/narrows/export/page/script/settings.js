// The settings of a page: their values, the address that says them, the sliders that change them.

/** Values by name, as they are at first, and as the address says. */
export function settingsOf({ canal, sliders }, hash) {
  const first = { ...canal, ...Object.fromEntries(sliders.map(({ name, value }) => [name, value])) };
  return { first, values: { ...first, ...readFrom(hash, sliders) } };
}

function readFrom(hash, sliders) {
  const asked = new URLSearchParams(hash.replace(/^#/, ""));
  const known = sliders.filter(({ name }) => asked.has(name) && asked.get(name) !== "" && Number.isFinite(+asked.get(name)));
  return Object.fromEntries(known.map(({ name, low, high }) => [name, Math.min(high, Math.max(low, +asked.get(name)))]));
}

/** What is not as it was at first, as an address. */
export function hashOf({ first, values }) {
  const changed = Object.entries(values).filter(([name, value]) => value !== first[name]);
  return changed.map(([name, value]) => `${name}=${+value.toPrecision(6)}`).join("&");
}

/** In what the settings go beyond what the tests covered. */
export function beyond({ sliders }, values) {
  return sliders.filter(({ name, tested }) => tested && (values[name] < tested[0] || values[name] > tested[1]));
}

export function controls(host, data, settings, changed) {
  const shows = data.sliders.map((slider) => row(group(host, slider.group), slider, settings, changed));
  const show = () => shows.forEach((one) => one());
  const back = document.createElement("button");
  Object.assign(back, { type: "button", textContent: "As at first", id: "first" });
  back.addEventListener("click", () => { Object.assign(settings.values, settings.first); changed(); });
  host.append(back);
  return show;
}

function group(host, name) {
  const known = [...host.querySelectorAll("[data-group]")].find((one) => one.dataset.group === name);
  if (known) return known;
  const folded = name === "Coefficients";
  const made = document.createElement(folded ? "details" : "fieldset");
  const title = document.createElement(folded ? "summary" : "legend");
  made.dataset.group = title.textContent = name;
  made.append(title);
  host.append(made);
  return made;
}

function row(host, slider, { values }, changed) {
  const label = document.createElement("label");
  const [text, output, input] = ["span", "output", "input"].map((kind) => document.createElement(kind));
  text.textContent = slider.label;
  const kind = slider.switch ? { type: "checkbox" } : { type: "range", min: slider.low, max: slider.high, step: slider.step };
  Object.assign(input, { ...kind, name: slider.name });
  label.append(text, output, input);
  label.classList.toggle("switch", Boolean(slider.switch));
  host.append(label);
  input.addEventListener("input", () => { values[slider.name] = slider.switch ? +input.checked : +input.value; changed(); });
  return () => {
    const value = values[slider.name];
    if (slider.switch) input.checked = value > 0;
    else input.value = value;
    const out = slider.tested && (value < slider.tested[0] || value > slider.tested[1]);
    const shown = slider.switch ? ["off", "on"][value] : said(value, slider);
    output.textContent = out ? `${shown} · ${slider.beyond}` : shown;
    output.classList.toggle("beyond", Boolean(out));
    if (!slider.switch) input.setAttribute("aria-valuetext", `${slider.label}: ${output.textContent}`);
  };
}

function said(value, { unit, digits }) {
  const number = value.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
  return /^[°%]?$/.test(unit) ? `${number}${unit}` : `${number} ${unit}`;
}
