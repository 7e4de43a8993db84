// Short tones while an alert sounds: three of an alarm, two of a warning. Browsers allow them after a press of a button.

const EVERY = { alarm: 3500, "emergency alarm": 2000, warning: 7000 };
const TONES = { alarm: 3, "emergency alarm": 3, warning: 2 };
const [PITCH, LONG, APART, LOUD] = [880, 0.16, 0.28, 0.25];
const [SILENT, SILENCE_EVERY] = [0.8, 5000];

export function sounds(button) {
  let context = null;
  let last = -Infinity;

  button.addEventListener("click", () => {
    context = context ? void context.close() : new AudioContext();
    button.setAttribute("aria-pressed", String(Boolean(context)));
    button.textContent = `Sound: ${context ? "on" : "off"}`;
  });

  setInterval(() => {
    // A monitor that falls silent is heard: one long tone.
    if (context && document.documentElement.hasAttribute("data-stale")) beep(context, context.currentTime, SILENT);
  }, SILENCE_EVERY);

  /** The most urgent alert that sounds, if any, is heard. */
  return (alerts) => {
    const loud = alerts.find((alert) => alert.sounds);
    if (!context || !loud || performance.now() - last < EVERY[loud.priority]) return;
    last = performance.now();
    for (let tone = 0; tone < TONES[loud.priority]; tone += 1) beep(context, context.currentTime + tone * APART);
  };
}

function beep(context, start, long = LONG) {
  const [tone, volume] = [context.createOscillator(), context.createGain()];
  tone.frequency.value = PITCH;
  volume.gain.value = LOUD;
  tone.connect(volume).connect(context.destination);
  tone.start(start);
  tone.stop(start + long);
}
