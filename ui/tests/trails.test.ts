import { Color } from "three";
import { expect, it } from "vitest";
import type { Palette } from "../src/draw/palette";
import { Trails } from "../src/draw/trails";
import { path } from "./support";

it("fade from their own colour to that of the view, never to a lighter one", () => {
  const colours = { view: "#f3f7fa", measured: "#0b6fae", filled: "#b07d00", edited: "#b0307a", missing: "#888888" } as Palette, trails = new Trails();
  trails.show([{ path: path("A", new Array<number>(40).fill(1)) }], 20, 20, 10, colours);
  const shown = trails.lines.geometry.getAttribute("color").array, ground = new Color(colours.view).toArray(), own = new Color(colours.measured).toArray();
  const first = [0, 1, 2].map((k) => shown[k]!), nearest = [0, 1, 2].map((k) => shown[6 * 19 + k]!);
  for (const k of [0, 1, 2]) {
    expect(Math.abs(first[k]! - ground[k]!)).toBeLessThan(0.15 * Math.abs(ground[k]! - own[k]!));
    expect(Math.abs(nearest[k]! - own[k]!)).toBeLessThan(0.4 * Math.abs(ground[k]! - own[k]!) + 0.01);
    for (let i = 0; i < 30; i++) expect(shown[6 * i + k]).toBeLessThanOrEqual(Math.max(ground[k]!, own[k]!) + 1e-3);
  }
});
