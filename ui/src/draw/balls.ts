/** The markers as balls, drawn as one: there is room for as many as are put. */
import { Color, IcosahedronGeometry, InstancedMesh, Matrix4, MeshBasicMaterial, type Scene as Graph } from "three";

/** mm, radius of a marker; chosen: of 14 mm spheres, a little larger. */
const RADIUS_MM = 11;
/** More than there are markers, as an edit adds one or two; chosen. */
const MORE = 8;

export class Balls {
  mesh: InstancedMesh | null = null;
  private n = 0;
  private readonly matrix = new Matrix4();
  private readonly hue = new Color();

  constructor(private readonly graph: Graph) {}

  /** Begin anew, with room for so many: what is drawn beyond it would be whatever the graphics card finds there. */
  begin(most: number): void {
    this.n = 0;
    if (this.mesh && this.mesh.instanceMatrix.count >= most) return;
    this.dispose();
    this.mesh = new InstancedMesh(new IcosahedronGeometry(RADIUS_MM, 1), new MeshBasicMaterial(), most + MORE);
    this.mesh.frustumCulled = false;
    this.graph.add(this.mesh);
  }

  put(x: number, y: number, z: number, size: number, colour: string): void {
    this.mesh!.setMatrixAt(this.n, this.matrix.makeScale(size, size, size).setPosition(x, y, z));
    this.mesh!.setColorAt(this.n++, this.hue.set(colour));
  }

  end(): void {
    const mesh = this.mesh!;
    mesh.count = this.n;
    mesh.instanceMatrix.needsUpdate = true;
    if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    if (!this.mesh) return;
    this.graph.remove(this.mesh);
    this.mesh.geometry.dispose();
    (this.mesh.material as MeshBasicMaterial).dispose();
    this.mesh.dispose();
    this.mesh = null;
  }
}
