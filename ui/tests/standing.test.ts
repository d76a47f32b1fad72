/** Why a screen cannot be shown is said of the screen that was asked about last. */
import { expect, it, vi } from "vitest";
import type { Standing } from "../src/api/types";
import { ready } from "../src/state/load";
import { get, set } from "../src/state/store";

const answers = new Map<string, (stands: Standing) => void>();
vi.mock("../src/api/client", async (real) => ({
  ...(await real<object>()),
  standing: (_id: string, screen: string) => new Promise<Standing>((done) => answers.set(screen, done)),
}));

it("says nothing of the screen that somebody went on from, however late its answer comes", async () => {
  set({ id: "t", unshown: "" });
  const of = [ready("t", "trial"), ready("t", "digitise")];
  answers.get("digitise")!({ ready: false, words: "Nobody digitises it.", runs: true });
  answers.get("trial")!({ ready: false, words: "It was not run yet.", runs: true });
  expect(await Promise.all(of)).toEqual([false, false]);
  expect(get().unshown).toBe("Nobody digitises it.");
});
