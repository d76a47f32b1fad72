/** What the page asks of the menu of UM²AS. */
import type { components } from "../api.gen";
import { body, json } from "./client";

type Schemas = components["schemas"];
export type Menu = Schemas["Um2asMenu"];
export type MenuRow = Schemas["MenuRow"];
export type Written = Schemas["Written"];
export type FilePage = Schemas["FilePage"];

const part = encodeURIComponent;
const of = (session: string): string => `/sessions/${part(session)}/um2as`;

export const menu = (session: string, said: { trial: string; cameras: readonly string[]; tdc: string }): Promise<Menu> =>
  json(`${of(session)}?trial=${part(said.trial)}&tdc=${part(said.tdc)}${said.cameras.map((name) => `&camera=${part(name)}`).join("")}`);
export const parameters = (session: string, trial: string, made: string): Promise<Written> => json(`${of(session)}/parameters?trial=${part(trial)}`, body({ made }));
export const markers = (session: string, trial: string): Promise<Written> => json(`${of(session)}/markers?trial=${part(trial)}`, body({}));
export const coordinates = (session: string, said: Schemas["CoordinatesBody"]): Promise<Written> => json(`${of(session)}/coordinates`, body(said));
export const angles = (session: string, said: Schemas["EulerBody"]): Promise<Written> => json(`${of(session)}/angles`, body(said));
export const page = (session: string, trial: string, name: string, frame: number): Promise<FilePage> =>
  json(`${of(session)}/files/${part(name)}?trial=${part(trial)}&frame=${frame}`);
export type Bars = Schemas["Bars"];
export type BarMeasured = Schemas["BarMeasured"];
export const bars = (session: string): Promise<Bars> => json(`${of(session)}/aspect`);
export const bar = (session: string, images: string, threshold: number | null): Promise<BarMeasured> => json(`${of(session)}/aspect`, body({ images, threshold }));
export const factor = (session: string, value: number | null): Promise<Bars> => json(`${of(session)}/aspect/factor`, body({ factor: value }));
