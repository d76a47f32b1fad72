/** What the page asks of the ways to calibrate a session. */
import type { components } from "../api.gen";
import { body, json } from "./client";
import type { SessionCameras } from "./sessions";

type Schemas = components["schemas"];
export type WayRow = Schemas["WayRow"];
export type Role = Schemas["WayBody"]["role"];
const of = (session: string): string => `/sessions/${encodeURIComponent(session)}/ways`;

export const ways = (session: string): Promise<Schemas["Ways"]> => json(of(session));
export const change = (session: string, said: Schemas["WayBody"]): Promise<SessionCameras> => json(of(session), body(said));
