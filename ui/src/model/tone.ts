/** A tone without a file: the last frame is reached. */

/** Hz, s, and loudness of 1; chosen: heard across a room, and no alarm. */
const PITCH_HZ = 880, LENGTH_S = 0.4, LOUD = 0.2;

export function tone(): void {
  try {
    const audio = new AudioContext(), source = audio.createOscillator(), gain = audio.createGain(), now = audio.currentTime;
    source.frequency.value = PITCH_HZ;
    gain.gain.setValueAtTime(LOUD, now);
    gain.gain.exponentialRampToValueAtTime(0.001, now + LENGTH_S); // so that it does not end in a click
    source.connect(gain).connect(audio.destination);
    source.onended = () => void audio.close();
    source.start(now);
    source.stop(now + LENGTH_S);
  } catch {
    // a machine without sound has the message
  }
}
