// The page for players and clients: shows what mossar sends, and asks it to teach, to forget and to count again.
import { Stage } from "/stage.js";

const at = (id) => document.getElementById(id);
const about = await (await fetch("/about.json")).json();
const root = document.documentElement;
const stage = new Stage(at("picture"), about.mirrored);
const eye = about.eye ? await import("/eye.js") : null;
let chosen = null; // name of the performer that is shown; null for the first
let version = null; // of the examples
let state = null;
let line = null;

function theme(dark) {
  root.dataset.theme = dark ? "dark" : "light";
  at("theme").textContent = dark ? "Light" : "Dark";
  stage.paint();
}

function ask(what) {
  if (line?.readyState === WebSocket.OPEN) line.send(JSON.stringify(what));
}

// Text is set only where it has changed, so that a screen reader says it once.
function put(id, text) {
  if (at(id).textContent !== text) at(id).textContent = text;
}

function clock(seconds) {
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
}

function shown() {
  const { performers } = state;
  return performers.find((one) => one.name === chosen) ?? performers.find((one) => !one.stale) ?? performers[0] ?? null;
}

function showBoard(person) {
  put("title", person?.title ?? "");
  const count = person?.count ?? null;
  put("count", count === null ? "" : String(count));
  at("count").classList.toggle("long", (count ?? 0) > 999);
  const share = Math.round(100 * (person?.progress ?? 0));
  document.querySelector("#ring .share").setAttribute("stroke-dasharray", `${share} 100`);
  put("verdict", person?.verdict ?? "");
  at("verdict").className = person?.kind ?? "wait";
  put("tempo", person?.tempo || "–");
  put("time", clock(person?.seconds ?? 0));
  put("others", (person?.others ?? []).map(([name, times]) => `${name} ${times}`).join(" · "));
  const names = state.performers.map((one) => one.name);
  at("performers").hidden = names.length < 2;
  if (at("performers").dataset.names !== names.join()) {
    at("performers").dataset.names = names.join();
    at("performers").replaceChildren(...names.map((name) => {
      const button = document.createElement("button");
      button.textContent = name;
      button.onclick = () => { chosen = name; };
      return button;
    }));
  }
}

const LARGE = { watch: "now", again: "again", taken: "taken", failed: "again" };

function showTeaching({ phase, runs, keep, undo, name, seconds, message, first, version: newest }) {
  put("teach", runs ? "Cancel" : "Teach");
  at("keep").hidden = !keep;
  at("undo").hidden = !undo || keep;
  if (!at("move").value && !at("move").dataset.touched) at("move").value = first;
  at("countdown").hidden = phase === "idle";
  at("countdown").className = phase === "count" ? "" : "word";
  if (phase !== "idle") {
    at("countdown").querySelector("b").textContent = phase === "count" ? seconds : LARGE[phase];
    at("countdown").querySelector("span").textContent =
      { count: `get ready for ${name}`, watch: message || `do ${name}, then rest`, again: `${message}; do ${name} again, or press Keep` }[phase] ?? message;
  }
  put("taught", runs ? "" : message);
  if (newest !== version) {
    version = newest;
    showExamples();
  }
}

async function showExamples() {
  const found = await (await fetch("/examples.json")).json();
  at("examples").replaceChildren(...found.map(({ name, place, mark, seconds, drawing }) => {
    const figure = document.createElement("figure");
    const picture = new DOMParser().parseFromString(`<div xmlns="http://www.w3.org/2000/svg">${drawing}</div>`, "image/svg+xml");
    const words = document.createElement("figcaption");
    words.textContent = `${name} ${seconds.toFixed(1)} s`;
    const button = document.createElement("button");
    button.textContent = "×";
    button.title = button.ariaLabel = `forget ${name}, ${seconds.toFixed(1)} s`;
    button.onclick = () => ask({ do: "forget", place, mark });
    figure.append(picture.documentElement.firstElementChild, words, button);
    return figure;
  }));
}

// The camera of this computer: a picture, and the people who were found in that very picture.
async function showCamera(person, jpeg) {
  const picture = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
  const alone = state.performers.length === 1 && state.people.length === 1;
  stage.showPicture(picture, state.people, state.outline, alone ? person?.strays : null);
  picture.close();
}

async function show(message) {
  let jpeg = null;
  if (typeof message === "string") {
    state = JSON.parse(message);
  } else {
    const length = new DataView(message).getUint32(0, true);
    state = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, length)));
    jpeg = new Uint8Array(message, 4 + length);
  }
  const person = shown();
  showBoard(person);
  showTeaching(state.teaching);
  put("note", eye ? eye.trouble() : state.note);
  if (eye?.sees) eye.colour(person?.strays ?? null);
  else if (jpeg) await showCamera(person, jpeg);
  else stage.showFigure(person);
}

function connect() {
  line = new WebSocket(`ws://${location.host}/live`);
  line.binaryType = "arraybuffer";
  line.onopen = () => ask({ do: "next" });
  line.onmessage = async ({ data }) => {
    try {
      await show(data);
    } finally {
      requestAnimationFrame(() => ask({ do: "next" }));
      if (document.hidden) ask({ do: "next" });
    }
  };
  line.onclose = () => {
    put("note", "the program has ended, or cannot be reached; start it again, and this page goes on");
    setTimeout(connect, 1000);
  };
}

at("move").oninput = () => { at("move").dataset.touched = "yes"; };
at("teaching").onsubmit = (event) => {
  event.preventDefault();
  ask(state?.teaching.runs ? { do: "cancel" } : { do: "teach", name: at("move").value });
};
at("keep").onclick = () => ask({ do: "keep" });
at("undo").onclick = () => ask({ do: "undo" });
at("again").onclick = () => ask({ do: "again" });
at("theme").onclick = () => theme(root.dataset.theme !== "dark");
at("dashboard").hidden = !about.dashboard;
theme(about.dark || matchMedia("(prefers-color-scheme: dark)").matches);
connect();
eye?.start(about.eye, stage, { cameras: at("cameras"), camera: at("camera"), models: at("models"), model: at("model") });
