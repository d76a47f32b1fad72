import { describe, expect, it } from "vitest";
import { chord, single } from "../src/keys/bind";
import { byId, clashes, COMMANDS, footLine, possible } from "../src/keys/commands";
import { SCREENS, useStore, type State } from "../src/state/store";
import { HEADER, PROBLEMS } from "./support";

const press = (key: string, more: Partial<KeyboardEvent> = {}): string => chord({ key, ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, ...more });
const state = (some: Partial<State>): State => ({ ...useStore.getInitialState(), ...some });

describe("the table of commands", () => {
  it("means one thing by each key on each screen", () => {
    expect(clashes()).toEqual([]);
  });

  it("finds a clash where there is one", () => {
    const twice = [byId("next"), { ...byId("exchange"), keys: ["N"] }];
    expect(clashes(twice)).toEqual(["tracks N: next and exchange"]);
  });

  it("leaves to the browser what is the browser's", () => {
    const taken = /^(Ctrl|Alt)\+(\d|N|T|W|L|R|Tab)$/;
    expect(COMMANDS.flatMap((c) => c.keys).filter((key) => taken.test(key))).toEqual([]);
  });

  it("has each id once, and words for every command", () => {
    expect(new Set(COMMANDS.map((c) => c.id)).size).toBe(COMMANDS.length);
    for (const c of COMMANDS) expect(c.title.length).toBeGreaterThan(2);
  });

  it("writes keys so that a press can mean them", () => {
    for (const key of COMMANDS.flatMap((c) => c.keys)) {
      const parts = key.split(/\+(?=.)/), last = parts.at(-1)!;
      const e = { key: last === "Space" ? " " : last, ctrlKey: parts.includes("Ctrl"), altKey: parts.includes("Alt"), shiftKey: parts.includes("Shift"), code: /^\d$/.test(last) ? `Digit${last}` : "" };
      expect(press(e.key, e)).toBe(key);
    }
  });

  it("says what each key would do in every state without failing", () => {
    for (const screen of SCREENS)
      for (const some of [{}, { header: HEADER, problems: PROBLEMS, problem: "p1", selected: ["LKNE", "*3"], first: 3, last: 9 }]) {
        const s = state({ screen, ...some });
        for (const c of COMMANDS) if (possible(c, s)) expect(typeof (c.hint?.(s) ?? c.title)).toBe("string");
      }
  });
});

describe("a trial that cannot be shown", () => {
  const shift = (some: Partial<State>): string[] => COMMANDS.filter((c) => c.keys.includes("Shift+Enter") && possible(c, state(some))).map((c) => c.id);

  it.each(["tracks", "labels", "gaps", "angles", "report", "history"] as const)("is run by Shift+Enter on %s, and nothing else is offered of it", (screen) => {
    const s = state({ screen, id: "t", unshown: "It was run by another one." });
    expect(shift(s)).toEqual(["run"]);
    expect(footLine(s).map((one) => one.id)).toEqual(["run", "print", "help", "up"]);
  });

  it("is not run while it is being read or run, nor where there is nothing to run", () => {
    expect(shift({ screen: "gaps", id: "t", unshown: "It was run by another one.", jobs: { t: { id: "1", trial: "t", state: "running" } as never } })).toEqual([]);
    expect(shift({ screen: "gaps", id: "t" })).toEqual([]);
    expect(shift({ screen: "gaps", id: "t", unshown: "This file is damaged.", runs: false })).toEqual([]);
  });

  it("keeps its keys once it is there", () => {
    expect(shift({ screen: "gaps", id: "t", header: HEADER })).toEqual(["gap-all"]);
    expect(shift({ screen: "labels", id: "t", header: HEADER })).toEqual(["labels-accept"]);
  });
});

describe("presses", () => {
  it("are the same on every keyboard", () => {
    expect(press("n")).toBe("N");
    expect(press("N", { shiftKey: true })).toBe("Shift+N");
    expect(press("?", { shiftKey: true })).toBe("?");
    expect(press("!", { shiftKey: true, code: "Digit1" })).toBe("Shift+1");
    expect(press("z", { metaKey: true })).toBe("Ctrl+Z");
    expect(press(" ")).toBe("Space");
    expect(press("[", { altKey: true, ctrlKey: true })).toBe("[");
    expect(press("]", { altKey: true })).toBe("]");
  });

  it("are the browser's where Alt goes to one of its tabs", () => {
    expect(press("1", { altKey: true, code: "Digit1" })).toBe("Alt+1");
    expect(press("2", { altKey: true, ctrlKey: true, code: "Digit2" })).toBe("Ctrl+Alt+2");
  });

  it("are single letters or not", () => {
    expect(["N", "Shift+N", "[", "-"].every(single)).toBe(true);
    expect(["Ctrl+Z", "Enter", "ArrowLeft"].some(single)).toBe(false);
  });
});

describe("the foot", () => {
  it("says first what Enter would do with the problem that is looked at", () => {
    const line = footLine(state({ screen: "tracks", header: HEADER, problems: PROBLEMS, problem: "p1", selected: ["LKNE", "*3"] }));
    expect(line[0]).toEqual({ key: "Enter", words: "Exchange them", id: "accept" });
  });

  it("says how many problems wait where none is looked at", () => {
    const line = footLine(state({ screen: "tracks", header: HEADER, problems: PROBLEMS }));
    expect(line[0]!.words).toBe("look at the first of 2 problems");
  });
});
