/** A view from any side: round a target, with the world's own axis up. Drag turns, Shift or the right button moves, the wheel comes nearer. */
import { PerspectiveCamera, Quaternion, Vector3 } from "three";

export type Side = "front" | "side" | "top" | "oblique";
const SIDES: Record<Side, [number, number]> = { oblique: [-0.9, 0.32], side: [-Math.PI / 2, 0.02], front: [0, 0.02], top: [-Math.PI / 2, 1.55] };
/** rad a px of dragging, and the share of the distance a notch of the wheel; chosen. */
const TURN = 0.006, NEARER = 0.0012;

export class Orbit {
  readonly target = new Vector3();
  /** From a world with Z up to the one that is shown. */
  readonly upright = new Quaternion();
  azimuth = SIDES.oblique[0];
  elevation = SIDES.oblique[1];
  distance = 4000;
  private readonly x = new Vector3();
  private readonly y = new Vector3();

  constructor(readonly camera: PerspectiveCamera, private readonly element: HTMLElement, private readonly changed: () => void, private readonly clicked: (x: number, y: number, more: boolean) => void) {
    element.addEventListener("pointerdown", this.down);
    element.addEventListener("wheel", this.wheel, { passive: false });
    element.addEventListener("contextmenu", this.menu);
  }

  dispose(): void {
    this.element.removeEventListener("pointerdown", this.down);
    this.element.removeEventListener("wheel", this.wheel);
    this.element.removeEventListener("contextmenu", this.menu);
  }

  side(side: Side): void {
    [this.azimuth, this.elevation] = SIDES[side];
    this.changed();
  }

  turn(azimuth: number, elevation: number): void {
    this.azimuth += azimuth;
    this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + elevation));
    this.changed();
  }

  zoom(factor: number): void {
    this.distance = Math.min(60000, Math.max(80, this.distance * factor));
    this.changed();
  }

  /** Look at a place in mm from so far. */
  look(x: number, y: number, z: number, distance = this.distance): void {
    this.target.set(x, y, z);
    this.distance = distance;
    this.changed();
  }

  /** The camera of three where this view has it. */
  place(): void {
    const c = Math.cos(this.elevation), d = this.distance;
    this.camera.position.set(d * c * Math.cos(this.azimuth), d * c * Math.sin(this.azimuth), d * Math.sin(this.elevation)).applyQuaternion(this.upright).add(this.target);
    this.camera.up.set(0, 0, 1).applyQuaternion(this.upright);
    this.camera.lookAt(this.target);
    this.camera.near = d / 50;
    this.camera.far = d * 20 + 20000;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  private readonly down = (event: PointerEvent): void => {
    let moved = 0;
    const move = (e: PointerEvent): void => {
      moved += Math.abs(e.movementX) + Math.abs(e.movementY);
      if (moved < 4) return;
      if (e.shiftKey || e.buttons & 6) this.pan(e.movementX, e.movementY);
      else this.turn(-e.movementX * TURN, e.movementY * TURN);
    };
    const up = (e: PointerEvent): void => {
      this.element.removeEventListener("pointermove", move);
      this.element.removeEventListener("pointerup", up);
      if (moved < 4 && e.button === 0) this.clicked(e.offsetX, e.offsetY, e.shiftKey || e.ctrlKey);
    };
    this.element.setPointerCapture(event.pointerId);
    this.element.addEventListener("pointermove", move);
    this.element.addEventListener("pointerup", up);
  };

  private pan(dx: number, dy: number): void {
    const perPx = (2 * this.distance * Math.tan((this.camera.fov * Math.PI) / 360)) / Math.max(1, this.element.clientHeight);
    this.x.setFromMatrixColumn(this.camera.matrixWorld, 0);
    this.y.setFromMatrixColumn(this.camera.matrixWorld, 1);
    this.target.addScaledVector(this.x, -dx * perPx).addScaledVector(this.y, dy * perPx);
    this.changed();
  }

  private readonly wheel = (event: WheelEvent): void => {
    event.preventDefault();
    this.zoom(Math.exp(event.deltaY * NEARER));
  };

  private readonly menu = (event: Event): void => event.preventDefault();
}
