/** What is drawn of a curve. */
import { describe, expect, it } from "vitest";
import { alone } from "../src/draw/Curves";

describe("samples with none beside them", () => {
  it("are drawn as dots, as a line draws nothing of them", () => {
    expect(alone([1, null, null, 2, 3, null, 4])).toEqual([0, 6]);
    expect(alone([null, 7, null])).toEqual([1]);
  });

  it("are none in a curve", () => {
    expect([alone([1, 2, 3]), alone([]), alone([null, null])]).toEqual([null, null, null]);
  });
});
