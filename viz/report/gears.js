// The pair as things to draw: gears, paths of contact, points of contact, posed at a roll of the pinion.
//
// Lengths are mm, in the fixed frame S_f (z along the pinion axis). Tooth pair k is tooth k of the pinion and
// tooth -k of the gear. All tooth pairs have the same path: at the pinion roll r, pair k is at the point
// where pair 0 is at the roll r + k times the angular pitch.
"use strict";

window.beveloidGears = function (data) {
  const T = window.THREE;
  // Clearance, mm, below which a pair counts as touching: the path is interpolated linearly between
  // its points.
  const TOUCHING = data.module / 3e4;
  const MOST = 8; // tooth pairs shown in contact at a time
  const DOT = 7; // radius of the dot at a point of contact, pixels
  const OVER = 1; // layer of all that is drawn over the teeth

  const vector = (values) => new T.Vector3(...values);

  function unpacked(packed) {
    // Low byte first, as on every machine that runs a browser.
    const bytes = Uint8Array.from(atob(packed.data), (letter) => letter.charCodeAt(0));
    const kinds = { float64: Float64Array, float32: Float32Array, uint32: Uint32Array, uint16: Uint16Array };
    return new kinds[packed.type](bytes.buffer);
  }

  function turned(points, angle) {
    const cos = Math.cos(angle),
      sin = Math.sin(angle),
      out = Float64Array.from(points);
    for (let i = 0; i < points.length; i += 3) {
      out[i] = cos * points[i] - sin * points[i + 1];
      out[i + 1] = sin * points[i] + cos * points[i + 1];
    }
    return out;
  }

  /* ---- gears ---- */

  const scene = new T.Scene();
  const cut = new T.Plane(); // what is on its wrong side is not drawn in a section
  const ink = {
    path: new T.LineMaterial({ linewidth: 3.5 }),
    hiddenPath: new T.LineMaterial({ linewidth: 2.5, transparent: true, opacity: 0.45, depthTest: false }),
    axis: new T.LineMaterial({ linewidth: 1.2 }),
  };

  function lines(polylines, material) {
    const ends = [];
    for (const line of polylines) {
      for (let i = 3; i < line.length; i += 3) ends.push(...line.slice(i - 3, i + 3));
    }
    const made = new T.LineSegments2(new T.LineSegmentsGeometry().setPositions(ends), material);
    made.layers.set(OVER);
    made.frustumCulled = false; // its box would have to be that of the thick line
    return made;
  }

  function toothOf(member) {
    const tooth = new T.BufferGeometry(),
      faces = unpacked(member.tooth.faces);
    const sides = faces.length - 3 * member.tooth.end_faces;
    tooth.setAttribute("position", new T.BufferAttribute(unpacked(member.tooth.points), 3));
    tooth.setAttribute("normal", new T.BufferAttribute(unpacked(member.tooth.normals), 3));
    tooth.setIndex(new T.BufferAttribute(faces, 1));
    tooth.addGroup(0, sides, 0);
    tooth.addGroup(sides, faces.length - sides, 1);
    return tooth;
  }

  function blankOf(member) {
    const [toe, heel] = member.tip_radius;
    return new T.CylinderGeometry(heel, toe, 2 * member.half_width, 128).rotateX(Math.PI / 2);
  }

  // Computes the frame of a member in S_f from its rotation and origin; moveTeeth() moves the teeth there.
  function setFrame(member) {
    const [a, b, c, d, e, f, g, h, i] = member.rotation,
      [x, y, z] = member.origin;
    member.matrix = new T.Matrix4().set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);
    return Object.assign(member, { axis: vector([c, f, i]), centre: vector(member.origin) });
  }

  // Moves the teeth to their frames and angles, unless no point moves by more than a tolerance in mm.
  function moveTeeth(tolerance) {
    const largest = ({ frame, spin, matrix, angle, half_width, tip_radius }) => {
      const change = matrix.elements.map((value, n) => value - frame.matrix.elements[n]),
        reach = Math.hypot(half_width, ...tip_radius);
      const turn = Math.hypot(...change.slice(0, 12)) + Math.abs(angle - spin.rotation.z);
      return Math.hypot(...change.slice(12)) + turn * reach;
    };
    if (Math.max(...members.map(largest)) <= tolerance) return;
    for (const { frame, spin, matrix, angle } of members) {
      frame.matrix.copy(matrix);
      frame.matrixWorldNeedsUpdate = true;
      spin.rotation.z = angle;
    }
  }

  function gearOf(member, j) {
    const frame = new T.Group(),
      spin = new T.Group(),
      turns = new T.Matrix4();
    frame.matrixAutoUpdate = false;
    // Set back a little, so that paths lie in front of the flanks they are on.
    const back = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 };
    const metal = () => new T.MeshStandardMaterial({ roughness: 0.5, metalness: 0.25, ...back });
    const materials = { side: metal(), end: metal(), inside: new T.MeshBasicMaterial({ side: T.BackSide }) };
    materials.depth = new T.MeshBasicMaterial({ colorWrite: false, ...back });
    const geometry = member.tooth ? toothOf(member) : blankOf(member),
      count = member.tooth ? member.teeth : 1;
    // See-through gears: depth first and colour after, so that only their front is seen. In a section one
    // looks through the cut at the inside of surfaces: in one plain colour that is the cut face.
    const surface = member.tooth ? [materials.side, materials.end] : materials.side;
    const [depth, , inside] = [materials.depth, surface, materials.inside].map((material, order) => {
      const mesh = new T.InstancedMesh(geometry, material, count);
      for (let k = 0; k < count; k++) mesh.setMatrixAt(k, turns.makeRotationZ((2 * Math.PI * k) / count));
      mesh.renderOrder = 5 + 2 * j + order;
      mesh.frustumCulled = false;
      spin.add(mesh);
      return mesh;
    });
    const reach = 1.6 * member.half_width;
    frame.add(spin, lines([[0, 0, -reach, 0, 0, reach]], ink.axis));
    scene.add(frame);
    const pitch = (2 * Math.PI) / member.teeth;
    return setFrame({ ...member, frame, spin, materials, depth, inside, pitch, display: "solid" });
  }

  const members = data.members.map(gearOf);
  const [pinion, gear] = members;

  /* ---- paths and points of contact ---- */

  function flankOf(given) {
    const { ends, phase, edges } = given.cycle;
    const cycle = { ...given.cycle, ends: unpacked(ends), phase: unpacked(phase) };
    cycle.edges = edges.map((edge) => edge && { ...edge, point: unpacked(edge.point) });
    if (!given.path) return { ...given, cycle, drawn: [] };
    const path = {};
    for (const [name, values] of Object.entries(given.path)) path[name] = unpacked(values);
    const drawn = members.map((member) => {
      const every = Array.from({ length: member.teeth }, (_, k) =>
        turned(path[member.name], k * member.pitch),
      );
      const first = lines([path[member.name]], ink.hiddenPath);
      const meshing = [first, ...Array.from({ length: MOST - 1 }, () => first.clone())]; // of one geometry
      for (const line of meshing) line.renderOrder = 15;
      const all = lines(every, ink.path);
      member.spin.add(all, ...meshing);
      return { all, meshing };
    });
    return { ...given, path, cycle, drawn };
  }

  const flanks = { right: flankOf(data.flanks.right), left: flankOf(data.flanks.left) };

  // Puts other frames of the members and another path of one flank in place of the present ones.
  function update(frames, flankName, given) {
    members.forEach((member, j) => {
      Object.assign(member, frames[j]);
      setFrame(member);
      const { all, meshing } = flanks[flankName].drawn[j] ?? { meshing: [] };
      for (const line of all ? [all, ...meshing] : []) {
        line.removeFromParent();
        line.geometry.dispose();
      }
    });
    flanks[flankName] = flankOf(given);
  }

  // Points of contact: dots with a rim, paler where something hides them.
  const ball = new T.SphereGeometry(1, 14, 8),
    rimInk = new T.MeshBasicMaterial({ side: T.BackSide });
  const pale = { depthTest: false, depthWrite: false, transparent: true, opacity: 0.5 };
  const dotInks = {};
  for (const kind of ["touching", "clear", "edge"]) {
    dotInks[kind] = [new T.MeshBasicMaterial(), new T.MeshBasicMaterial(pale)];
  }
  const dots = Array.from({ length: MOST + 1 }, () => {
    const dot = new T.Group(),
      rim = new T.Mesh(ball, rimInk);
    const cores = dotInks.touching.map((material) => new T.Mesh(ball, material));
    rim.scale.setScalar(1.35);
    cores[1].renderOrder = 20;
    dot.add(rim, ...cores);
    for (const part of dot.children) part.layers.set(OVER);
    scene.add(dot);
    return { dot, cores, at: new T.Vector3() };
  });

  function place(one, contact, kind) {
    one.dot.visible = Boolean(contact);
    if (!contact) return;
    one.at.copy(contact.point);
    one.cores.forEach((core, i) => (core.material = dotInks[kind][i]));
  }

  /* ---- who touches ---- */

  // Returns the value at x (-1 to 1) of the Chebyshev series number n. `rows` holds the coefficients of
  // `parts` series of equal length, one after the other (Clenshaw's algorithm).
  function series(rows, parts, n, x) {
    const size = rows.length / parts;
    let [sum, before] = [0, 0];
    for (let k = size - 1; k > 0; k--) [sum, before] = [2 * x * sum - before + rows[n * size + k], sum];
    return x * sum - before + rows[n * size];
  }

  // The gear's phase at a roll, and the edge in contact, if there is one.
  function atCycle({ cycle }, roll) {
    const { start, pitch, ends, phase, edges } = cycle;
    const into = roll - start - Math.floor((roll - start) / pitch) * pitch;
    const n = Math.max(0, ends.findIndex((end) => into <= end));
    const low = n ? ends[n - 1] : 0,
      x = (2 * (into - low)) / (ends[n] - low) - 1;
    const edge = edges[n];
    return {
      phase: series(phase, ends.length, n, x),
      edge: edge && { name: edge.edge, point: vector([0, 1, 2].map((c) => series(edge.point, 3, c, x))) },
    };
  }

  // Tooth pairs on their path: number, roll of pair 0 there, point, normal, and clearance.
  function onPath({ path, lever }, roll, phase) {
    const found = [];
    if (!path) return found;
    const least = Math.ceil((Math.min(...path.roll) - roll) / pinion.pitch);
    const most = Math.floor((Math.max(...path.roll) - roll) / pinion.pitch);
    for (let pair = least; pair <= most; pair++) {
      const own = roll + pair * pinion.pitch;
      for (let i = 0; i + 1 < path.roll.length; i++) {
        // All pieces are looked at: where the roll turns back along a path, a pair touches twice.
        const share = (own - path.roll[i]) / (path.roll[i + 1] - path.roll[i]);
        if (!(share >= 0 && (share < 1 || (share === 1 && i + 2 === path.roll.length)))) continue;
        const at = (values, n) =>
          values[n] + share * (values[n + values.length / path.roll.length] - values[n]);
        const [point, normal] = [path.point, path.normal].map((v) =>
          vector([0, 1, 2].map((c) => at(v, 3 * i + c))),
        );
        const gap = Math.abs(at(path.phase, i) - phase) * lever;
        found.push({ pair, roll: own, point, normal, gap, touches: gap < TOUCHING });
      }
    }
    return found.slice(0, MOST);
  }

  // The middle of a path: the tooth pair that is nearest to it at a roll, and point and normal there.
  function middleOf(flank, roll) {
    const { path, middle } = flank,
      pair = Math.round((middle - roll) / pinion.pitch);
    if (!path)
      return { pair, point: vector(data.mesh_point), normal: vector([0, flank === flanks.left ? -1 : 1, 0]) };
    const n = 3 * (path.roll.length >> 1),
      [point, normal] = [path.point, path.normal].map((v) => vector(v.slice(n, n + 3)));
    return { pair, point, normal };
  }

  function radialOf(member, point) {
    const out = point.clone().sub(member.centre);
    return out.addScaledVector(member.axis, -out.dot(member.axis)).normalize();
  }

  function alongTooth({ point, normal }) {
    const along = normal.clone().cross(radialOf(pinion, point)).normalize();
    return along.dot(pinion.axis) > 0 ? along.negate() : along; // towards -z
  }

  function pose(roll, flankName, section) {
    const flank = flanks[flankName],
      { phase, edge } = atCycle(flank, roll),
      found = onPath(flank, roll, phase);
    pinion.angle = roll;
    gear.angle = phase - (pinion.teeth / gear.teeth) * roll;
    dots.forEach((one, n) =>
      n < MOST ? place(one, found[n], found[n]?.touches ? "touching" : "clear") : place(one, edge, "edge"),
    );
    for (const each of Object.values(flanks)) {
      each.drawn.forEach(({ all, meshing }, j) => {
        all.visible = each === flank && !section; // in a section they would lie over the cut faces
        meshing.forEach((line, n) => {
          line.visible = each === flank && n < found.length;
          if (line.visible) line.rotation.z = (j ? -1 : 1) * found[n].pair * members[j].pitch;
        });
      });
    }
    // The section is perpendicular to the tooth through the contact nearest to the middle of its path.
    const off = (one) => Math.abs(one.roll - flank.middle);
    const there =
      found.reduce((best, one) => (off(one) < off(best) ? one : best), found[0]) ?? middleOf(flank, roll);
    cut.setFromNormalAndCoplanarPoint(alongTooth(there).negate(), there.point);
    return { found, edge };
  }

  /* ---- how it looks ---- */

  function show(j, display, section) {
    const member = members[j],
      { side, end } = member.materials,
      glass = display === "glass";
    member.display = display;
    member.frame.visible = display !== "hidden";
    member.depth.visible = glass;
    member.inside.visible = section && !glass;
    for (const material of Object.values(member.materials)) {
      Object.assign(material, { clippingPlanes: section ? [cut] : null, needsUpdate: true });
    }
    for (const material of [side, end]) {
      Object.assign(material, { transparent: glass, opacity: glass ? 0.4 : 1, depthWrite: !glass });
    }
  }

  function recolour(colour) {
    const panel = colour("panel"),
      path = colour("path"),
      white = new T.Color("white");
    for (const { name, materials } of members) {
      materials.side.color.copy(colour(name));
      materials.end.color.copy(colour(name)).lerp(white, 0.25);
      materials.inside.color.copy(colour(name)).lerp(panel, 0.35);
    }
    ink.path.color.copy(path);
    ink.hiddenPath.color.copy(path);
    ink.axis.color.copy(colour("muted"));
    rimInk.color.copy(panel);
    const dotColours = { touching: path, clear: path.clone().lerp(panel, 0.55), edge: colour("accent") };
    for (const [kind, both] of Object.entries(dotInks))
      both.forEach((material) => material.color.copy(dotColours[kind]));
  }

  // Dots keep their size on the screen, and are in front of the flank they are on.
  function sizeDots(camera, height) {
    const perPixel = (2 * Math.tan((camera.fov * Math.PI) / 360)) / height;
    for (const { dot, at } of dots) {
      const towards = camera.position.clone().sub(at),
        size = DOT * perPixel * towards.length();
      dot.scale.setScalar(size);
      dot.position.copy(at).addScaledVector(towards.normalize(), 1.5 * size);
    }
  }

  /* ---- places on the gears, in the world ---- */

  // The point of a tip circle (end 0 at -z, 1 at +z) that lies furthest along a direction.
  function onRim(member, end, direction, beyond = 0) {
    const across = direction.clone().addScaledVector(member.axis, -direction.dot(member.axis)).normalize();
    const middle = member.centre.clone().addScaledVector(member.axis, (2 * end - 1) * member.half_width);
    return middle.addScaledVector(across, member.tip_radius[end] + beyond);
  }

  function rims(member) {
    const round = Array.from({ length: 24 }, (_, n) => (n * Math.PI) / 12);
    const directions = round.map((angle) =>
      vector([Math.cos(angle), Math.sin(angle), 0]).transformDirection(member.matrix),
    );
    return [0, 1].flatMap((end) => directions.map((direction) => onRim(member, end, direction)));
  }

  // Returns the corners of the flank of a tooth pair: root and tip at -z, then root and tip at +z;
  // undefined for a blank without teeth.
  function corners(member, flankName, pair) {
    const turn = member.angle + (member === gear ? -1 : 1) * pair * member.pitch;
    return member.tooth?.corners[flankName].map((point) =>
      vector(turned(point, turn)).applyMatrix4(member.matrix),
    );
  }

  function dispose() {
    scene.traverse((one) => {
      one.geometry?.dispose();
      for (const material of [one.material ?? []].flat()) material.dispose();
    });
  }

  return {
    scene,
    over: OVER,
    members,
    flanks,
    pose,
    moveTeeth,
    update,
    show,
    recolour,
    sizeDots,
    middleOf,
    radialOf,
    alongTooth,
    onRim,
    rims,
    corners,
    dispose,
  };
};
