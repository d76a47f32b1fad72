/** What the page asks of sessions: those still to be made, their cameras, and the angles of their trials. */
import type { components } from "../api.gen";
import { body, json } from "./client";

type Schemas = components["schemas"];
export type NewFolder = Schemas["NewFolder"];
export type Proposed = Schemas["ProposedSession"];
export type Said = Partial<Schemas["SaidOfRecordings"]>;
export type Role = Schemas["RecordingRow"]["role"];
export type SessionCameras = Schemas["SessionCameras"];
export type CalibrationShown = Schemas["CalibrationShown"];
export type TableRows = Schemas["TableRows"];
export type FindingRow = Schemas["FindingRow"];
export type Control = Schemas["Control"];
export type ControlCamera = Schemas["ControlCamera"];
export type White = Schemas["WhitePixels"];
export type Ball = Partial<Schemas["BallBody"]> & { point: string };
export type Angles = Required<Schemas["AnglesShown"]>;
export type AngleCurve = Schemas["AngleCurve"];
export type AngleChoice = Partial<Schemas["AngleChoice"]>;
export type Spike = Schemas["Spike"];

const part = encodeURIComponent;
const recordings = (id: string): string => `/recordings/${part(id)}`;
const session = (id: string): string => `/sessions/${part(id)}`;
const angle = (trial: string): string => `/trials/${part(trial)}/angles`;

export const folders = (): Promise<{ folders: NewFolder[] }> => json("/recordings");
export const proposal = (id: string, said: Said): Promise<Proposed> => json(`${recordings(id)}/proposal`, body(said));
export const make = (id: string, said: Said): Promise<Schemas["MadeSession"]> => json(`${recordings(id)}/session`, body(said));
export const cameras = (id: string): Promise<SessionCameras> => json(`${session(id)}/cameras`);
export const numbers = (id: string, said: Record<string, number[]>): Promise<SessionCameras> => json(`${session(id)}/numbers`, body({ numbers: said }));
export const calibrate = (id: string): Promise<unknown> => json(`${session(id)}/calibrate`, body({}));
export const control = (id: string): Promise<Control> => json(`${session(id)}/control`);
export const ball = (id: string, camera: string, said: Ball): Promise<Control> => json(`${session(id)}/control/${part(camera)}`, body(said));
export const white = (id: string, camera: string, threshold: number | null, inverted: boolean): Promise<White> =>
  json(`${session(id)}/control/${part(camera)}/white?inverted=${inverted}${threshold === null ? "" : `&threshold=${threshold}`}`);
export const threshold = (id: string, said: { camera: string | null; threshold: number; inverted: boolean }): Promise<Control> => json(`${session(id)}/threshold`, body(said));
export const controlImage = (id: string, camera: string): string => `/api${session(id)}/control/${part(camera)}/image`;
export const gaitPage = (id: string): string => `/api${session(id)}/gait`;
export const makeGait = (id: string): Promise<Schemas["Standing"]> => json(`${session(id)}/gait`, body({}));
export const calibrationPage = (id: string): string => `/api${session(id)}/calibration`;
export const angles = (trial: string, said: AngleChoice): Promise<Angles> => json(angle(trial), body(said));
export const spike = (trial: string, said: AngleChoice & { joint: number; turn: number; frame: number }): Promise<Spike> => json(`${angle(trial)}/spike`, body(said));
export const euler = (trial: string, said: AngleChoice): Promise<{ names: string[] }> => json(`${angle(trial)}/export`, body(said));

/** Numbers that came as base64 of float32. */
export function unpacked(text: string): Float32Array {
  const raw = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(raw.buffer);
}
