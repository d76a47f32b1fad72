/** The records of the server, by their own names. */
import type { components } from "../api.gen";

type Schemas = components["schemas"];
/** What the server fills in where the page leaves it out. */
type Loose<T> = T extends { kind: infer K } ? { kind: K } & Partial<Omit<T, "kind">> : never;

export type Home = Schemas["Home"];
export type TrialCard = Schemas["TrialCard"];
export type SessionCard = Schemas["SessionCard"];
export type TrialHeader = Schemas["TrialHeader"];
export type TrackRow = Schemas["TrackRow"];
export type CameraRow = Schemas["CameraRow"];
export type Mosaic = Schemas["Mosaic"];
export type MarkerSetRow = Schemas["MarkerSetRow"];
export type Action = Schemas["Alternative"]["action"];
export type Problem = Schemas["Problem"];
export type Problems = Schemas["Problems"];
export type Alternative = Schemas["Alternative"];
type One = Loose<Exclude<Schemas["ActBody"]["act"], { kind: "several" }>>;
export type Act = One | { kind: "several"; acts: One[] };
export type ActDone = Schemas["ActDone"];
export type Outcome = Schemas["Outcome"];
export type Preview = Schemas["Preview"];
export type Join = Schemas["Join"];
export type Gaps = Schemas["Gaps"];
export type GapRow = Schemas["GapRow"];
export type Candidate = Schemas["Candidate"];
export type GapCandidates = Schemas["GapCandidates"];
export type Labels = Schemas["Labels"];
export type Proposal = Schemas["Proposal"];
export type History = Schemas["History"];
export type HistoryRow = Schemas["HistoryRow"];
export type Difference = Schemas["Difference"];
export type Job = Schemas["Job"];
export type Live = Schemas["Live"]["said"];
export type PathsHeader = Schemas["PathsHeader"];
export type DetectionsHeader = Schemas["DetectionsHeader"];
