/** What the page asks of the server: one function a route. */
import { decodeDetections, type Detected } from "../model/detections";
import { decodePaths, type PathSet } from "../model/paths";
import type {
  Act, ActDone, DetectionsHeader, Difference, GapCandidates, Gaps, History, Home, Labels, MarkerSetChoice, PathsHeader, Preview, Problems,
  Standing, TrialHeader, AnswerBody, DetectDraft, DetectFrame, Detection, DigitisingNow, PlacedMarker, PlaceWhy, SetupBody, StartUp, WhyBody,
} from "./types";

/** The server refused: its words are for the person. `head` where the journal has gone on since. */
export class Refused extends Error {
  constructor(readonly status: number, words: string, readonly head: string | null = null) {
    super(words);
  }
}

async function asked(path: string, init?: RequestInit): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(`/api${path}`, init);
  } catch {
    throw new Refused(0, "The studio's server does not answer. What you did is saved; start it again to go on.");
  }
  if (answer.ok) return answer;
  const said: unknown = await answer.json().catch(() => null);
  const { words, head } = wordsOf(said);
  throw new Refused(answer.status, words ?? `The server answered ${answer.status} to ${path}.`, head);
}

/** The words of a refusal, in whichever envelope they come. */
export function wordsOf(said: unknown): { words: string | null; head: string | null } {
  if (typeof said !== "object" || said === null) return { words: null, head: null };
  const { words, head, detail } = said as { words?: unknown; head?: unknown; detail?: unknown };
  if (typeof words === "string") return { words, head: typeof head === "string" ? head : null };
  if (typeof detail === "string") return { words: detail, head: null };
  if (Array.isArray(detail)) return { words: detail.map((d: { msg?: string }) => d.msg ?? "").join("; "), head: null };
  return detail ? wordsOf(detail) : { words: null, head: null };
}

export const json = async <T>(path: string, init?: RequestInit): Promise<T> => (await (await asked(path, init)).json()) as T;
export const body = (value: unknown, method = "POST"): RequestInit => ({
  method,
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(value),
});
const part = encodeURIComponent;
const of = (id: string): string => `/trials/${part(id)}`;

/** Whether the server knows this window; null where there is none. One that was started anew does not. */
export const known = (): Promise<boolean | null> => fetch("/api/jobs").then((answer) => answer.status !== 403, () => null);
export const home = (): Promise<Home> => json("/home");
export const trial = (id: string): Promise<TrialHeader> => json(of(id));
/** Whether a screen of a trial can be shown; what stands in its way is told in words, and is no error of the browser's. */
export const standing = (id: string, screen: "trial" | "detect" | "digitise" | "report"): Promise<Standing> => json(`${of(id)}/standing?screen=${screen}`);
/** Null where the trial is edited while they are looked for: who shows that asks again. */
export const problems = (id: string): Promise<Problems | null> => json(`${of(id)}/problems`);
export const gaps = (id: string): Promise<Gaps> => json(`${of(id)}/gaps`);
export const gap = (id: string, marker: string, first: number): Promise<GapCandidates | null> =>
  json(`${of(id)}/gaps/${part(marker)}/${first}`);
export const markerSets = (id: string): Promise<MarkerSetChoice[]> => json(`${of(id)}/marker-sets`);
export const wear = (id: string, name: string | null): Promise<MarkerSetChoice[]> => json(`${of(id)}/marker-set`, body({ name }));
export const labels = (id: string, ask = false): Promise<Labels> => json(`${of(id)}/labels${ask ? "?ask=true" : ""}`);
export const history = (id: string): Promise<History> => json(`${of(id)}/history`);
export const difference = (id: string, from: number, to: number): Promise<Difference> =>
  json(`${of(id)}/diff?of=${from}&other=${to}`);

export async function paths(id: string, view: string, markers: readonly string[] = []): Promise<PathSet> {
  const some = markers.length ? `&${markers.map((name) => `marker=${part(name)}`).join("&")}` : "";
  const answer = await asked(`${of(id)}/paths?view=${view}${some}`);
  const header = JSON.parse(answer.headers.get("X-Kinemark-Paths") ?? "null") as PathsHeader;
  return decodePaths(header, await answer.arrayBuffer());
}

export async function detections(id: string, first: number, last: number): Promise<Detected> {
  const answer = await asked(`${of(id)}/detections?first=${first}&last=${last}`);
  const header = JSON.parse(answer.headers.get("X-Kinemark-Detections") ?? "null") as DetectionsHeader;
  return decodeDetections(header, await answer.arrayBuffer());
}

export const act = (id: string, head: string, what: Act, why = ""): Promise<ActDone> =>
  json(`${of(id)}/acts`, body({ head, act: what, why }));
export const preview = (id: string, what: Act): Promise<Preview | null> => json(`${of(id)}/preview`, body({ act: what }));
export const run = (id: string): Promise<unknown> => json(`${of(id)}/run`, body({}));
export const cancel = async (id: string): Promise<void> => void (await asked(`${of(id)}/run`, { method: "DELETE" }));
export const exportTrial = (id: string): Promise<{ name: string; words: string[] }> => json(`${of(id)}/export`, body({}));
export const drop = (file: File): Promise<{ id: string; words: string[] }> =>
  json(`/files?name=${part(file.name)}`, { method: "POST", body: file });

export const reportAddress = (id: string): string => `/api${of(id)}/report`;
export const reportPdf = async (id: string): Promise<Blob> => (await asked(`${of(id)}/report.pdf`)).blob();
/** Numbers of frames mean other images where not all are taken, or cameras are put in time: browsers keep images by their address. */
const taken = (every: number): string => (every > 1 ? `?every=${every}` : "");
export const mosaicAddress = (id: string, frame: number, images: string): string => `/api${of(id)}/mosaic/${frame}?images=${images}`;
/** The same before it is looked at: nothing is given where it was not made yet. */
export const aheadAddress = (id: string, frame: number, images: string): string => `/api${of(id)}/mosaic/${frame}?ahead=true&images=${images}`;
export const partAddress = (id: string, camera: string, frame: number, images: string, x: number, y: number, w: number, h: number): string =>
  `/api${of(id)}/cameras/${part(camera)}/${frame}?x=${x}&y=${y}&w=${w}&h=${h}&images=${images}`;

export const detection = (id: string): Promise<Detection> => json(`${of(id)}/detect`);
export const detectFrame = (id: string, frame: number, draft: DetectDraft, cameras: readonly string[] = []): Promise<DetectFrame> => json(`${of(id)}/detect/frame`, body({ frame, draft, cameras }));
export const detectWhy = (id: string, what: WhyBody): Promise<PlaceWhy> => json(`${of(id)}/detect/why`, body(what));
export const detectApply = (id: string, draft: DetectDraft): Promise<Detection> => json(`${of(id)}/detect/apply`, body(draft));
export const digitising = (id: string): Promise<DigitisingNow> => json(`${of(id)}/digitise`);
export const answer = (id: string, what: AnswerBody): Promise<DigitisingNow> => json(`${of(id)}/digitise/answers`, body(what));
export const savedFrame = (id: string, frame: number): Promise<PlacedMarker[]> => json(`${of(id)}/digitise/frames/${frame}`);
export const pictureAddress = (id: string, camera: string, frame: number, every: number): string => `/api${of(id)}/pictures/${part(camera)}/${frame}${taken(every)}`;
export const setUpDigitising = (id: string, what: SetupBody): Promise<DigitisingNow> => json(`${of(id)}/digitise/setup`, body(what));
export const startUp = (id: string): Promise<StartUp> => json(`${of(id)}/digitise/setup`);
export const leaveDigitising = async (id: string): Promise<void> => void (await asked(`${of(id)}/digitise/setup`, { method: "DELETE" }));
