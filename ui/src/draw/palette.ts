/** The colours of the theme that is on, for what is drawn and not laid out. */
export interface Palette {
  view: string; ink: string; line: string; faint: string; measured: string; filled: string; edited: string; missing: string;
  hatch: string; a: string; b: string; select: string; accent: string; bad: string; warn: string; paper: string; good: string;
}

const NAMES: Record<keyof Palette, string> = {
  view: "--view", ink: "--view-ink", line: "--view-line", faint: "--view-faint", measured: "--measured", filled: "--filled",
  edited: "--edited", missing: "--missing", hatch: "--hatch", a: "--a", b: "--b", select: "--select", accent: "--accent",
  bad: "--bad", warn: "--warn", paper: "--paper", good: "--good",
};

let known: { theme: string | undefined; colours: Palette } | null = null;

/** Read anew when the theme changes. */
export function palette(): Palette {
  const { theme } = document.documentElement.dataset;
  if (!known || known.theme !== theme) known = { theme, colours: read() };
  return known.colours;
}

function read(): Palette {
  const style = getComputedStyle(document.documentElement);
  const entries = Object.entries(NAMES).map(([key, name]) => [key, style.getPropertyValue(name).trim()]);
  return Object.fromEntries(entries) as unknown as Palette;
}

/** Colours of origins in their order: missing, measured, filled, edited. */
export const byOrigin = (p: Palette): string[] => [p.missing, p.measured, p.filled, p.edited];

/** Red, green and blue from 0 to 1 of #rrggbb. */
export function rgb(colour: string): [number, number, number] {
  const full = colour.length === 4 ? colour.replace(/[0-9a-f]/gi, "$&$&") : colour;
  return [1, 3, 5].map((i) => parseInt(full.slice(i, i + 2), 16) / 255) as [number, number, number];
}

/** A canvas as large as its place on the screen, in its own pixels; whether that changed. */
export function fit(canvas: HTMLCanvasElement, width: number, height: number): number {
  const scale = Math.min(window.devicePixelRatio || 1, 2);
  const w = Math.max(1, Math.round(width * scale)), h = Math.max(1, Math.round(height * scale));
  if (canvas.width !== w) canvas.width = w;
  if (canvas.height !== h) canvas.height = h;
  return scale;
}

export const SANS = '12px Inter, "Segoe UI", system-ui, "Liberation Sans", "DejaVu Sans", sans-serif';
