"""What a flow in the browser costs a person, counted from the keys and clicks that the page was given.

By the keystroke-level model (Card, Moran and Newell 1980): a key, a movement of the mouse with its click, a hand that
goes from one to the other, and a mental act before each of them, save where a key is repeated or text is typed.
"""

from support.screen_operator import KEY_S, MENTAL_S, POINT_S

HAND_S = 0.4
"""s of a hand between mouse and keys; of the model."""
MODIFIERS = {"Shift", "Control", "Alt", "Meta"}
HEARD = """(() => {
  let byKey = false;
  const acted = (kind, what) => void window.kinemarkActed(kind, what), is = (e, of) => e.target.matches(of);
  addEventListener("keydown", (e) => ((byKey = true), acted("key", e.key)), true);
  addEventListener("keyup", () => (byKey = false), true);
  addEventListener("pointerdown", () => acted("click", ""), true);
  addEventListener("change", (e) => is(e, "select") && !byKey && (acted("click", ""), acted("click", "")), true);
  addEventListener("input", (e) => {
    if (byKey || is(e, "select, [type=checkbox], [type=radio]")) return;
    if (is(e, "[type=range]")) acted("click", "");
    else acted("typed", e.data ?? e.target.value);
  }, true);
})()"""
"""A field that is filled at once is typed, a key a letter; a choice of a list is two clicks, a slider one."""


class Effort:
    """Of one flow, over all its windows."""

    def __init__(self):
        self.begin()

    def begin(self):
        self.keys = self.clicks = self.typed = 0
        self.seconds, self.last = 0.0, ("", "")

    def watch(self, page):
        page.expose_binding("kinemarkActed", lambda _source, kind, what: self.acted(kind, what))
        page.add_init_script(HEARD)

    def acted(self, kind, what):
        if kind == "key" and what in MODIFIERS:
            return
        hand = "mouse" if kind == "click" else "keys"
        self.seconds += HAND_S if self.last[0] not in ("", hand) else 0.0
        self.seconds += 0.0 if kind == "key" and self.last == (hand, what) else MENTAL_S
        self.seconds += {"key": KEY_S, "click": POINT_S, "typed": KEY_S * len(what)}[kind]
        self.keys, self.clicks = self.keys + (kind == "key"), self.clicks + (kind == "click")
        self.typed += len(what) if kind == "typed" else 0
        self.last = (hand, what)

    def said(self):
        return f"{self.keys} keys, {self.clicks} clicks, {self.typed} letters, {self.seconds:.0f} s predicted"


EFFORT = Effort()
"""Of the test that runs."""
