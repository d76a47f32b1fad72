import { expect, test } from "vitest";
import { Names, wouldBe } from "../src/draw/names";

function drawn(): { names: Names; written: [string, number, number][] } {
  const written: [string, number, number][] = [];
  const c = { measureText: (what: string) => ({ width: 7 * what.length }), strokeText: () => {}, fillText: (what: string, x: number, y: number) => void written.push([what, x, y]) };
  return { names: new Names(c as unknown as CanvasRenderingContext2D, "#fff"), written };
}
const over = ([a, x, y]: [string, number, number], [b, u, v]: [string, number, number]): boolean => Math.abs(y - v) < 13 && x < u + 7 * b.length && u < x + 7 * a.length;

test("names of markers that are selected stand beside each other, others give way", () => {
  const { names, written } = drawn();
  names.write("A LSMH", [100, 100], "", true);
  names.write("A LFMH", [104, 101], "", true);
  names.write("B LSMH", [103, 99], "", true);
  names.write("LTOE", [101, 102], "");
  names.write("RTOE", [300, 102], "");
  expect(written.map(([what]) => what)).toEqual(["A LSMH", "A LFMH", "B LSMH", "RTOE"]);
  for (const [i, one] of written.entries()) for (const other of written.slice(i + 1)) expect(over(one, other)).toBe(false);
});

test("names of many markers that lie in one another do not stand over each other", () => {
  const { names, written } = drawn();
  for (let k = 0; k < 8; k++) names.write(`${k < 4 ? "A" : "B"} M${k % 4}`, [100 + k, 100], "", true);
  expect(written.length).toBe(8);
  for (const [i, one] of written.entries()) for (const other of written.slice(i + 1)) expect(over(one, other)).toBe(false);
});

test("where no place is left, what must be read is written still", () => {
  const { names, written } = drawn();
  for (let k = 0; k < 40; k++) names.write(`A M${k}`, [100, 100], "", true);
  expect(written.length).toBe(40);
});

test("a piece that would be without a name is called by none of the program's own", () => {
  expect(["LTOE", "track22", "track22_1349", "tracker"].map(wouldBe)).toEqual(["B LTOE", "B", "B", "B tracker"]);
});
