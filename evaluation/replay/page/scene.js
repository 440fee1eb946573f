// The scene of a simulated run, from scene.json: shapes of the model, each fixed to a body whose poses are known over time.

function capsule(radius, half, segments) {
  const points = [];
  for (let i = 0; i <= segments; ++i) {
    const angle = -Math.PI / 2 + Math.PI / 2 * i / segments;
    points.push(new THREE.Vector2(Math.max(1e-6, radius * Math.cos(angle)), radius * Math.sin(angle) - half));
  }
  for (let i = 0; i <= segments; ++i) {
    const angle = Math.PI / 2 * i / segments;
    points.push(new THREE.Vector2(Math.max(1e-6, radius * Math.cos(angle)), radius * Math.sin(angle) + half));
  }
  return new THREE.LatheBufferGeometry(points, 16).rotateX(Math.PI / 2);
}

function meshGeometry(mesh) {
  const geometry = new THREE.BufferGeometry();
  const corners = mesh.triangles, positions = new Float32Array(3 * corners.length);
  for (let i = 0; i < corners.length; ++i) {
    for (let k = 0; k < 3; ++k) positions[3 * i + k] = mesh.vertices[3 * corners[i] + k];
  }
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  if (mesh.texels.length) geometry.setAttribute("uv", new THREE.BufferAttribute(new Float32Array(mesh.texels), 2));
  geometry.computeVertexNormals();
  return geometry;
}

function shapeGeometry(geom, meshes) {
  const size = geom.size;
  switch (geom.shape) {
    case "plane": return new THREE.PlaneBufferGeometry(2 * size[0] || 20, 2 * size[1] || 20);
    case "sphere": return new THREE.SphereBufferGeometry(size[0], 32, 20);
    case "ellipsoid": return new THREE.SphereBufferGeometry(1, 24, 16).scale(size[0], size[1], size[2]);
    case "capsule": return capsule(size[0], size[1], 6);
    case "cylinder": return new THREE.CylinderBufferGeometry(size[0], size[0], 2 * size[1], 24).rotateX(Math.PI / 2);
    case "box": return new THREE.BoxBufferGeometry(2 * size[0], 2 * size[1], 2 * size[2]);
    default: return meshes[geom.mesh];
  }
}

function drawnInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl");
  const names = gl && gl.getExtension("WEBGL_debug_renderer_info");
  return Boolean(names) && /swiftshader|llvmpipe|software/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
}

class SceneView {
  constructor(canvas, scene, colours) {
    this.canvas = canvas;
    this.bodies = scene.bodies;
    const software = drawnInSoftware();
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !software});
    this.renderer.setPixelRatio(software ? 0.5 : Math.min(window.devicePixelRatio || 1, 2));
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0x23252b);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f9c, 0.75));
    const sun = new THREE.DirectionalLight(0xffffff, 0.5);
    sun.position.set(0.8, 0.6, 1.6);
    this.scene.add(sun);
    this.changed = true;
    this.groups = scene.bodies.map(() => new THREE.Group());
    this.groups.forEach((group) => this.scene.add(group));
    const meshes = scene.meshes.map(meshGeometry);
    const textures = scene.textures.map((text) => {
      const texture = new THREE.TextureLoader().load("data:image/jpeg;base64," + text, () => { this.changed = true; });
      texture.flipY = false;
      texture.generateMipmaps = false;  // its sides are no powers of two
      texture.minFilter = THREE.LinearFilter;
      return texture;
    });
    for (const geom of scene.geoms) {
      const material = new THREE.MeshLambertMaterial({color: new THREE.Color(geom.rgba[0], geom.rgba[1], geom.rgba[2])});
      if (geom.texture !== undefined) material.map = textures[geom.texture];
      if (geom.rgba[3] < 1) {
        material.transparent = true;
        material.opacity = geom.rgba[3];
      }
      const mesh = new THREE.Mesh(shapeGeometry(geom, meshes), material);
      this.place(mesh, geom.pose);
      this.groups[geom.body].add(mesh);
    }
    // Gaze is known in the root frame.
    this.root = this.groups[Math.max(0, scene.bodies.findIndex((body) => body.name === "root"))];
    this.addGaze(colours);
    this.camera = new THREE.PerspectiveCamera(42, 1, 0.02, 30);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => { this.changed = true; });
    this.setView("overview");
  }

  place(object, pose) {
    object.position.set(pose[0], pose[1], pose[2]);
    object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
  }

  addGaze(colours) {
    // Of length 1 from the origin along z.
    const rod = new THREE.CylinderBufferGeometry(0.0022, 0.0022, 1, 8).translate(0, 0.5, 0).rotateX(Math.PI / 2);
    this.axis = new THREE.Mesh(rod, new THREE.MeshBasicMaterial({color: colours.gaze}));
    this.root.add(this.axis);
    const mark = (colour, radius) => {
      const object = new THREE.Mesh(new THREE.SphereBufferGeometry(radius, 12, 8), new THREE.MeshBasicMaterial({color: colour}));
      this.root.add(object);
      return object;
    };
    this.fixation = mark(colours.gaze, 0.009);
    this.target = mark(colours.target, 0.013);
  }

  setView(name) {
    this.view = name;
    const views = {overview: [[0.75, 0.85, 0.95], [-0.25, 0, 0.2]], behind: [[0.75, 0.05, 0.65], [-0.5, 0, 0.25]],
      side: [[-0.2, 1.5, 0.35], [-0.25, 0, 0.2]], front: [[-1.3, -0.35, 0.55], [0, 0, 0.25]]};
    this.controls.enabled = name !== "eye";
    this.camera.fov = name === "eye" ? 60 : 42;
    if (views[name]) {
      this.camera.position.set(...views[name][0]);
      this.controls.target.set(...views[name][1]);
      this.controls.update();
    }
    this.changed = true;
  }

  poseBodies(t) {
    const a = new THREE.Quaternion(), b = new THREE.Quaternion();
    this.bodies.forEach((body, index) => {
      const poses = body.poses, group = this.groups[index];
      let low = 0, high = poses.length;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (poses[middle][0] <= t) low = middle + 1;
        else high = middle;
      }
      const before = poses[Math.max(0, low - 1)], after = poses[Math.min(low, poses.length - 1)];
      const share = after[0] > before[0] ? Math.min(1, Math.max(0, (t - before[0]) / (after[0] - before[0]))) : 0;
      group.position.set(...[1, 2, 3].map((i) => before[i] + (after[i] - before[i]) * share));
      a.set(before[5], before[6], before[7], before[4]);
      b.set(after[5], after[6], after[7], after[4]);
      group.quaternion.copy(a).slerp(b, share);
    });
  }

  poseGaze(t, eye, gaze) {
    const eyeRow = rowAt(eye, t, 20e3), gazeRow = rowAt(gaze, t, 20e3);
    const point = (name) => {
      const at = ["x", "y", "z"].map((c) => gazeRow < 0 ? NaN : gaze[name + "_" + c][gazeRow]);
      return at[0] === at[0] ? at : null;
    };
    const fixation = point("fixation"), target = point("target");
    this.fixation.visible = fixation !== null;
    if (fixation) this.fixation.position.set(...fixation);
    this.target.visible = target !== null;
    if (target) this.target.position.set(...target);
    this.axis.visible = eyeRow >= 0 && this.view !== "eye";
    if (eyeRow < 0) return;
    const from = [eye.x[eyeRow], eye.y[eyeRow], eye.z[eyeRow]];
    const direction = [eye.axis_x[eyeRow], eye.axis_y[eyeRow], eye.axis_z[eyeRow]];
    const length = fixation ? Math.hypot(...fixation.map((v, i) => v - from[i])) : 1;
    this.axis.position.set(...from);
    this.axis.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...direction).normalize());
    this.axis.scale.set(1, 1, length);
    if (this.view !== "eye") return;
    this.camera.position.copy(this.root.localToWorld(new THREE.Vector3(...from)));
    this.camera.lookAt(this.root.localToWorld(new THREE.Vector3(...from.map((v, i) => v + direction[i]))));
  }

  // Poses of bodies are in the events' clock, `t` and tables since the start.
  draw(t, start, eye, gaze) {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (width !== this.width || height !== this.height) {
      this.width = width;
      this.height = height;
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(1, height);
    }
    this.camera.updateProjectionMatrix();
    this.poseBodies(t + start);
    this.root.updateMatrixWorld(true);
    this.poseGaze(t, eye, gaze);
    this.renderer.render(this.scene, this.camera);
    this.changed = false;
  }
}
