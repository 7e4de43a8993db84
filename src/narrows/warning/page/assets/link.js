// The connection to the monitor: opened anew when it breaks, for as long as the page is open.

const PAUSE = 1000;

/** Calls `heard` with every message, and `refused` with the sentence of a server that does not let us in. */
export function link(heard, refused) {
  let socket = null;

  function open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    socket = new WebSocket(`${scheme}//${location.host}/updates${location.search}`);
    let welcome = false;
    socket.onopen = () => (welcome = true);
    socket.onmessage = (event) => heard(JSON.parse(event.data));
    socket.onclose = () => {
      if (!welcome) askWhy(refused);
      setTimeout(open, PAUSE);
    };
  }

  open();
  return {
    send(message) {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    },
  };
}

/** A browser does not tell why a websocket was refused; the page itself is refused in words. */
async function askWhy(refused) {
  try {
    const answer = await fetch(location.href);
    if (!answer.ok) refused(await answer.text());
  } catch {
    refused("The monitor does not answer.");
  }
}
