// The machine in three dimensions: links that move as the joints say, bodies, camera, contact point.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const LINKS = [0x9aa3ab, 0x8fb0a9, 0xb3a48f, 0x9d9ab8, 0xa9b38f, 0xb39aa5, 0x8fa5b3];
const ROLES = { flute: 0xe0b430, shank: 0xb8b8b0, holder: 0x60656b, fixture: 0xc08a5a, part: 0x79a86b, stock: 0xa5c79b };
const PAIR = [0xd6322c, 0x2664d2];
const MOST_TRIANGLES_WITH_EDGES = 50000;

export class Scene {
  constructor(canvas, data) {
    this.data = data;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xffffff);
    this.camera = new THREE.PerspectiveCamera(35, 1, 1, 1e5);
    this.camera.up.set(0, 0, 1);
    const lamp = new THREE.DirectionalLight(0xffffff, 1.8);
    lamp.position.set(0.4, 0.6, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera, new THREE.HemisphereLight(0xffffff, 0x999990, 1.6));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => { this.dirty = true; });
    this.addLinks();
    this.addBodies();
    this.addMark();
    this.addLine();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  addLinks() {
    this.links = this.data.links.map((link) => Object.assign(new THREE.Group(), { name: link.name }));
    this.data.links.forEach((link, number) => {
      (link.parent < 0 ? this.scene : this.links[link.parent]).add(this.links[number]);
    });
  }

  addBodies() {
    const geometries = this.data.meshes.map(({ vertices, faces }) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
      geometry.setIndex(new THREE.BufferAttribute(faces, 1));
      return geometry;
    });
    const edges = geometries.map((geometry) => geometry.index.count < 3 * MOST_TRIANGLES_WITH_EDGES
      ? new THREE.EdgesGeometry(geometry, 30) : undefined);
    this.bodies = this.data.bodies.map((body) => {
      const group = new THREE.Group();
      for (const part of body.parts) {
        const color = ROLES[part.role] ?? LINKS[body.link % LINKS.length];
        const material = new THREE.MeshLambertMaterial({ color, flatShading: true, side: THREE.DoubleSide });
        const mesh = new THREE.Mesh(geometries[part.mesh], material);
        mesh.userData.color = color;
        group.add(mesh);
        if (edges[part.mesh]) {
          const line = new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.25 });
          group.add(new THREE.LineSegments(edges[part.mesh], line));
        }
      }
      this.links[body.link].add(group);
      return { ...body, group, state: "shown" };
    });
  }

  addMark() {
    const material = new THREE.MeshBasicMaterial({ color: 0xffbe00, depthTest: false, transparent: true });
    this.mark = new THREE.Mesh(new THREE.TorusGeometry(1, 0.22, 12, 48), material);
    this.mark.renderOrder = 1;
    this.mark.visible = false;
    this.scene.add(this.mark);
  }

  addLine() {
    const look = { color: 0xffbe00, depthTest: false, transparent: true };
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6), 3));
    const line = new THREE.Line(geometry, new THREE.LineBasicMaterial(look));
    const ends = new THREE.Points(geometry, new THREE.PointsMaterial({ ...look, size: 6, sizeAttenuation: false }));
    for (const drawn of [line, ends]) Object.assign(drawn, { frustumCulled: false, renderOrder: 1 });
    this.line = new THREE.Group().add(line, ends);
    this.line.visible = false;
    this.scene.add(this.line);
  }

  /** Pose every link: displacement from the zero pose, its parent's included by the tree. */
  pose(positions, time) {
    const turn = new THREE.Quaternion(), axis = new THREE.Vector3(), point = new THREE.Vector3();
    this.data.joints.forEach((joint, number) => {
      const link = this.links[joint.child];
      axis.fromArray(joint.axis);
      if (joint.rotary) {
        point.fromArray(joint.point);
        turn.setFromAxisAngle(axis, THREE.MathUtils.degToRad(positions[number] % 360));
        link.quaternion.copy(turn);
        link.position.copy(point).sub(point.clone().applyQuaternion(turn));
      } else {
        link.position.copy(axis).multiplyScalar(positions[number]);
      }
    });
    for (const body of this.bodies) {
      const present = !body.spans || body.spans.some(
        ([from, to]) => from <= time && (time < to || to === this.data.duration));
      body.group.visible = present && body.state !== "hidden";
    }
    this.dirty = true;
  }

  /** Show, ghost or hide a body. */
  setState(number, state) {
    const body = this.bodies[number];
    body.state = state;
    for (const { material, isMesh } of body.group.children) {
      const ghost = state === "ghost";
      material.transparent = ghost || !isMesh;
      material.opacity = ghost ? 0.15 : isMesh ? 1 : 0.25;
      material.depthWrite = !ghost;
      material.needsUpdate = true;
    }
    this.dirty = true;
  }

  /** Colour the two bodies of a pair, and no others. */
  highlight(pair) {
    for (const body of this.bodies) {
      const side = pair ? pair.indexOf(body.name) : -1;
      for (const mesh of body.group.children.filter((child) => child.isMesh)) {
        mesh.material.color.set(side < 0 ? mesh.userData.color : PAIR[side]);
      }
    }
    this.dirty = true;
  }

  /** Mark a point of the world, or nothing. */
  setMark(point) {
    this.mark.visible = Boolean(point);
    if (point) this.mark.position.fromArray(point);
    this.dirty = true;
  }

  /** Draw a line between two points of the world, six numbers, or none. */
  setLine(points) {
    this.line.visible = Boolean(points);
    if (points) this.line.children[0].geometry.attributes.position.copyArray(points).needsUpdate = true;
    this.dirty = true;
  }

  /** Box around bodies as they stand; the names of a pair, or all. */
  box(names) {
    this.scene.updateMatrixWorld(true);
    const box = new THREE.Box3();
    for (const body of this.bodies) {
      if (body.group.visible && (!names || names.includes(body.name))) box.expandByObject(body.group);
    }
    return box;
  }

  /** A ball that holds every vertex of the bodies that are seen, about the middle of their box. */
  ball() {
    const center = this.box().getCenter(new THREE.Vector3()), vertex = new THREE.Vector3();
    let radius = 0;
    for (const { group } of this.bodies.filter((body) => body.group.visible)) {
      for (const mesh of group.children.filter((child) => child.isMesh)) {
        const { position } = mesh.geometry.attributes;
        for (let index = 0; index < position.count; index++) {
          vertex.fromBufferAttribute(position, index).applyMatrix4(mesh.matrixWorld);
          radius = Math.max(radius, vertex.distanceTo(center));
        }
      }
    }
    return { center, radius };
  }

  /** Look from a direction at a ball of the world: all of it is seen, however wide the view is. */
  look(direction, center, radius) {
    const towards = new THREE.Vector3(...direction).normalize();
    const up = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(up, Math.atan(Math.tan(up) * this.camera.aspect));
    const distance = radius / Math.sin(narrow);
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(towards, distance);
    this.camera.near = distance / 1000;
    this.camera.far = distance * 100;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.dirty = true;
  }

  /** Look at the whole machine from a direction, by default from the front, right and above. */
  lookAtAll(direction = [0.5, -0.9, 0.6]) {
    const { center, radius } = this.ball();
    this.look(direction, center, radius);
  }

  /** Look at a point, or at the middle of a pair, from where the camera is. */
  lookNear(point, pair) {
    const sizes = pair.map((name) => this.box([name])).filter((box) => !box.isEmpty());
    if (!sizes.length) return;
    const small = sizes.reduce((a, b) => a.getSize(new THREE.Vector3()).length()
      < b.getSize(new THREE.Vector3()).length() ? a : b);
    const ball = small.getBoundingSphere(new THREE.Sphere());
    const center = point ? new THREE.Vector3(...point) : ball.center;
    const direction = this.camera.position.clone().sub(this.controls.target);
    this.look(direction.toArray(), center, (point ? 0.6 : 1.2) * ball.radius);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  /** Draw if anything changed. */
  draw() {
    if (!this.dirty) return;
    this.dirty = false;
    const away = this.camera.position.distanceTo(this.mark.position);
    this.mark.scale.setScalar(away * 0.012);
    this.mark.quaternion.copy(this.camera.quaternion);
    this.renderer.render(this.scene, this.camera);
  }
}
