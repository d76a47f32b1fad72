/** A world in which another axis than Z goes up stands upright in the view. */
import { PerspectiveCamera, Vector3 } from "three";
import { expect, it } from "vitest";
import { Orbit } from "../src/draw/orbit";
import { standing, uprightOf } from "../src/draw/room";

const UPS: [number, number, number][] = [[0, 0, 1], [0, 1, 0], [1, 0, 0], [0, -1, 0], [0, 0, -1]];

it.each(UPS)("what goes up in the world goes up on the screen: %s %s %s", (...up) => {
  const camera = new PerspectiveCamera(35, 1, 10, 60000), element = { addEventListener: () => {} } as unknown as HTMLElement;
  const orbit = new Orbit(camera, element, () => {}, () => {});
  orbit.upright.copy(uprightOf(up));
  orbit.look(100, 200, 300, 4000);
  orbit.place();
  const [below, above] = [0, 500].map((h) => new Vector3(100 + h * up[0], 200 + h * up[1], 300 + h * up[2]).project(camera)) as [Vector3, Vector3];
  expect(Math.abs(above.x - below.x)).toBeLessThan(1e-9);
  expect(above.y - below.y).toBeGreaterThan(0.1);
});

it("knows the floor of a world with Y up", () => {
  const [low, high] = standing([-1, 0, 2], [3, 1800, 5], uprightOf([0, 1, 0]));
  expect([low, high].map((at) => at.map((v) => Math.round(v)))).toEqual([[-1, -5, 0], [3, -2, 1800]]);
});
