// Asks the server that this page came from, and hears what it finds.

const RETRIES = 5; // after the stream of answers broke off
const RETRY = 1000; // [ms] between two of them

const live = {
  token: new URLSearchParams(location.search).get("token") ?? "",
  window: Array.from(crypto.getRandomValues(new Uint8Array(8)), (x) => x.toString(16)).join("-"),
  number: 0, // of the newest wish or task
  wish: 0, // of the newest wish
  asked: null, // the state of the newest wish
  sending: Promise.resolve(),
  waiting: 0, // number of the wish whose quick answer is awaited, 0 for none
  ended: false,
};

const asBearer = () => ({ Authorization: `Bearer ${live.token}` });

function inWords({ what, where, remedy }) {
  return `${where ? `${where}: ` : ""}${what}${remedy ? `; ${remedy}` : ""}`;
}

// The answer of the server, or an error in its words.
async function ask(path, body) {
  const how = body === undefined ? {} : { method: "POST", body: JSON.stringify(body) };
  const answer = await fetch(path, { ...how, headers: asBearer() });
  const told = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(inWords(told.error)), { refused: answer.status < 500 });
  return told;
}

// Hands every event to `hear`. A stream that breaks off is opened again some times.
async function listen(hear, lost) {
  for (let tries = 0; tries < RETRIES && !live.ended; tries++) {
    try {
      const answer = await fetch(`/events?window=${live.window}`, { headers: asBearer() });
      if (!answer.ok) throw new Error(inWords((await answer.json()).error));
      const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
      let text = "";
      for (let part = await reader.read(); !part.done; part = await reader.read()) {
        tries = 0;
        const parts = (text + part.value).split("\n\n");
        text = parts.pop();
        for (const one of parts) if (one.startsWith("data: ")) hear(JSON.parse(one.slice(6)));
      }
    } catch (error) {
      if (live.ended) return;
      lost(error.message);
    }
    await new Promise((go) => setTimeout(go, RETRY));
  }
  lost("the server has ended: start it again, and open its new link");
}

window.addEventListener("pagehide", () => { live.ended = true; });
