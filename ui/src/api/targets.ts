/** What the page asks of calibration targets in images. */
import type { components } from "../api.gen";
import { json } from "./client";

export type FoundInImage = components["schemas"]["FoundInImage"];
const part = encodeURIComponent;
const of = (session: string): string => `/sessions/${part(session)}/targets`;
const at = (session: string, kind: string, camera: string, frame: number): string => `${of(session)}/${part(kind)}/${part(camera)}/${frame}`;

export const targets = (session: string): Promise<{ kinds: Record<string, string> }> => json(of(session));
export const found = (session: string, kind: string, camera: string, frame: number): Promise<FoundInImage> => json(at(session, kind, camera, frame));
export const targetImage = (session: string, kind: string, camera: string, frame: number): string => `/api${at(session, kind, camera, frame)}/image`;
