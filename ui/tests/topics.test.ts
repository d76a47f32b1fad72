import { describe, expect, it } from "vitest";
import { COMMANDS } from "../src/keys/commands";
import { commandsOf, find, TOPICS } from "../src/keys/topics";
import { SCREENS, TITLES } from "../src/state/store";

/** What people of the field type, and the topic that must then come first. */
const ASKED: Record<string, string> = {
  rename: "rename", relabel: "rename", label: "labels", swap: "swap", switch: "swap", "left right": "sides", gap: "gaps", interpolate: "gaps", occlusion: "gaps",
  threshold: "threshold", "grey level": "threshold", mask: "mask", reflection: "mask", wand: "numbers", ghost: "ghost", delete: "ghost", merge: "join", split: "cut",
  spike: "spike", "heel strike": "event", knee: "angles", export: "finish", pdf: "report", print: "report", signature: "sign", undo: "undo", save: "saved", escape: "escape",
  occluded: "absent", digitizing: "digitise", import: "new-session", vicon: "drop", filter: "smooth", shortcut: "keys", journal: "history", dlt: "calibrate",
};

describe("the topics of the help", () => {
  it.each(Object.entries(ASKED))("%s finds %s first", (typed, id) => {
    expect(find(typed)[0]?.id).toBe(id);
  });

  it("speak of commands that there are, and of every command", () => {
    const said = new Set(TOPICS.flatMap((t) => [...t.text.matchAll(/\{([^}]*)\}/g)].map((m) => m[1])));
    expect([...said].filter((id) => !COMMANDS.some((c) => c.id === id))).toEqual([]);
    expect(COMMANDS.map((c) => c.id).filter((id) => !said.has(id))).toEqual([]);
  });

  it("are found by all of the words that are typed, begun or whole, and by nothing else", () => {
    expect(find("fill").map((t) => t.id)).toContain("gaps");
    expect(find("gap fil")[0]?.id).toBe("gaps");
    expect(find("gap zebra")).toEqual([]);
    expect(find("").length).toBe(TOPICS.length);
  });

  it("are of the screen that is on where nothing was typed", () => {
    expect(new Set(find("", "gaps").slice(0, 3).map((t) => t.screen))).toEqual(new Set(["gaps"]));
  });

  it("have each id once, say enough, and are of screens that there are", () => {
    expect(new Set(TOPICS.map((t) => t.id)).size).toBe(TOPICS.length);
    for (const t of TOPICS) expect(t.text.length).toBeGreaterThan(60);
    expect(SCREENS.filter((screen) => !TOPICS.some((t) => t.screen === screen))).toEqual([]);
  });
});

describe("the table that the manual is checked against", () => {
  it("is that of the page; `npm run keys` writes it", async () => {
    const screens = SCREENS.map((id) => ({ id, title: TITLES[id] }));
    const commands = COMMANDS.map(({ id, keys, title, group, screens: on }) => ({ id, keys, title, group, screens: on ?? null }));
    const topics = TOPICS.map((t) => ({ ...t, commands: commandsOf(t).map((c) => c.id) }));
    await expect(`${JSON.stringify({ screens, commands, topics }, null, 1)}\n`).toMatchFileSnapshot("../keys.json");
  });
});
