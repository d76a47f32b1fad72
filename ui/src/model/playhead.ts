/**
 * The frame that everything shows. It moves sixty times a second, so it is no state of React: what draws listens to
 * it, at most once a picture of the screen.
 */
export type Listener = (frame: number) => void;

export class Playhead {
  frame = 1;
  first = 1;
  last = 1;
  rate = 100;
  /** Frames that playing goes round in; null for all. */
  loop: readonly [number, number] | null = null;
  playing = false;
  /** Of the recording's own speed. */
  pace = 1;
  private readonly listeners = new Set<Listener>();
  private readonly states = new Set<() => void>();
  private waiting = 0;
  private began = 0;
  private from = 0;

  set(first: number, frames: number, rate: number): void {
    this.pause();
    Object.assign(this, { first, last: first + frames - 1, rate, loop: null });
    this.go(first);
  }

  on(listener: Listener): () => void {
    this.listeners.add(listener);
    return () => void this.listeners.delete(listener);
  }

  /** Playing or not. */
  onState(listener: () => void): () => void {
    this.states.add(listener);
    return () => void this.states.delete(listener);
  }

  go(frame: number): void {
    this.frame = Math.round(Math.min(this.last, Math.max(this.first, frame)));
    this.from = this.frame;
    this.began = performance.now();
    this.draw();
  }

  step(by: number): void {
    this.pause();
    this.go(this.frame + by);
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  play(): void {
    if (this.playing) return;
    this.playing = true;
    const [first, last] = this.loop ?? [this.first, this.last];
    if (this.frame >= last || this.frame < first) this.frame = first;
    this.from = this.frame;
    this.began = performance.now();
    this.said();
    this.draw();
  }

  pause(): void {
    if (!this.playing) return;
    this.playing = false;
    this.said();
  }

  /** Everything is drawn again in the next picture, whatever changed. */
  draw(): void {
    if (!this.waiting) this.waiting = requestAnimationFrame(this.tick);
  }

  private readonly tick = (now: number): void => {
    this.waiting = 0;
    if (this.playing) {
      const [first, last] = this.loop ?? [this.first, this.last];
      const span = last - first + 1, gone = Math.floor(((now - this.began) / 1000) * this.rate * this.pace);
      this.frame = first + ((((this.from - first + gone) % span) + span) % span);
    }
    for (const listener of this.listeners) listener(this.frame);
    if (this.playing) this.draw();
  };

  private said(): void {
    for (const listener of this.states) listener();
  }
}
