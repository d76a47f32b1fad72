/** What the server says by itself: how runs go on, and that a journal has gone on elsewhere. */
import { again, refetch, goTo, say, tried } from "../state/load";
import { get, set } from "../state/store";
import { fetchCameras, now } from "../state/sessions";
import * as api from "./client";
import type { Job, Live } from "./types";

/** ms before the socket is opened again, the first time and at most; chosen. */
const SOON = 500, LATE = 8000;

let wait = SOON;

export function connect(): void {
  const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/live`);
  socket.onopen = (): void => {
    const was = get().connected;
    wait = SOON;
    set({ connected: true, stranger: false });
    if (!was) void again(), say("news", "The server is there again.");
  };
  socket.onmessage = (message: MessageEvent<string>): void => heard(JSON.parse(message.data) as Live);
  socket.onclose = (): void => {
    set({ connected: false });
    void api.known().then((known) => set({ stranger: known === false }));
    setTimeout(connect, wait);
    wait = Math.min(LATE, wait * 2);
  };
}

function heard(said: Live): void {
  if (said.kind === "job") return job(said);
  const { id, header, busy } = get();
  if (said.trial !== id || !header || said.head === header.head || busy) return;
  void refetch().then(() => say("news", "This trial has gone on in another window; it is shown as it is now."));
}

function job(said: Job): void {
  set((s) => ({ jobs: { ...s.jobs, [said.trial]: said } }));
  if (said.state === "running") return;
  if (said.state === "failed") say("refused", said.words);
  if (said.trial === now().session) void fetchCameras();
  if (get().screen === "home") void tried(api.home).then((home) => home && set({ home }));
  else if (said.trial === get().id && said.state === "done") set({ header: null }), goTo(get().screen);
}
