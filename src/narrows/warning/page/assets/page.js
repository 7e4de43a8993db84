// The page of the monitor: what it hears, shown; what is asked for on it, sent.

import { alertList } from "./alert_list.js";
import { drawing } from "./drawing.js";
import { link } from "./link.js";
import { palettes } from "./palettes.js";
import { readout } from "./readout.js";
import { sounds } from "./sounds.js";
import { staleness } from "./staleness.js";
import { capital } from "./words.js";

const find = (name) => document.getElementById(name);
const canal = drawing(find("canal"));
const write = readout(find);
const sound = sounds(find("sound"));
const alerts = alertList(find, (message) => connection.send(message), (words) => (find("spoken").textContent = words));
const age = staleness((stale, words) => {
  document.documentElement.toggleAttribute("data-stale", stale);
  find("stale").hidden = !stale;
  find("stale-words").textContent = words;
  if (stale) document.title = "No update · narrows monitor";
});

const heard = {
  update(message) {
    write(message);
    alerts.show(message.alerts, [message.headline, ...message.caveats]);
    sound(message.alerts);
    canal.draw(message);
    age.fresh();
  },
  refused: ({ sentence }) => (find("refused").textContent = `Refused. ${capital(sentence)}`),
  ended: ({ sentence }) => age.over(sentence),
};

palettes(document.getElementsByName("palette"), () => canal.recolour());
const connection = link((message) => heard[message.kind]?.(message), (words) => age.why(words));
