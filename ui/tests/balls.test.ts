/** Balls of all markers, and of what would be of all of them. */
import { Scene } from "three";
import { expect, it } from "vitest";
import { Balls } from "../src/draw/balls";

it("has room for whatever is drawn: beyond it the graphics card drew the whole view in one colour", () => {
  const graph = new Scene(), balls = new Balls(graph);
  for (const n of [41, 82, 41]) {
    balls.begin(n);
    for (let k = 0; k < n; k++) balls.put(k, 0, 0, 1, "#123456");
    balls.end();
    expect(balls.mesh!.count).toBe(n);
    expect(balls.mesh!.instanceMatrix.count).toBeGreaterThanOrEqual(n);
    expect(balls.mesh!.instanceColor!.count).toBeGreaterThanOrEqual(n);
    expect(graph.children).toEqual([balls.mesh]);
  }
});
