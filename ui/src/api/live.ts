/** What the server says by itself: how runs go on, and that a journal has gone on elsewhere. */
import { quiet } from "../state/acts";
import { again, fetchHome, refetch, goTo, say, wasShown } from "../state/load";
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
  void quiet().then(() => moved(said.trial, said.head)); // an act of this page is heard of before it is answered
}

async function moved(trial: string, head: string): Promise<void> {
  const { id, header } = get();
  if (trial !== id || !header || wasShown(head)) return;
  await refetch();
  say("news", "This trial has gone on in another window; it is shown as it is now.");
}

function job(said: Job): void {
  set((s) => ({ jobs: { ...s.jobs, [said.trial]: said } }));
  if (said.state === "running") return;
  if (said.state === "failed") say("refused", said.words);
  if (said.trial === now().session) {
    if (said.state === "done") set({ note: null }); // which says that it is being done
    void fetchCameras();
  }
  if (get().screen === "home") void fetchHome();
  else if (said.trial === get().id && said.state === "done") set({ header: null }), goTo(get().screen);
}
