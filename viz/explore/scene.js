// Contact pattern on the teeth of the 3D view: window.beveloidPattern(gears).
"use strict";

window.beveloidPattern = function (gears) {
  const T = window.THREE;
  const material = new T.MeshBasicMaterial({
    transparent: true,
    opacity: 0.5,
    depthWrite: false,
    side: 2, // both sides
    forceSinglePass: true, // otherwise both sides are compiled anew for each picture
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -2,
  });
  const shown = [null, null];

  // The part of a triangle in which the level, linear between the corners, is negative.
  function clipped(corners) {
    const kept = [];
    corners.forEach((a, n) => {
      const b = corners[(n + 1) % 3];
      if (a.level < 0) kept.push(a.point);
      if (a.level < 0 !== b.level < 0) {
        const share = a.level / (a.level - b.level);
        kept.push(a.point.map((value, k) => value + share * (b.point[k] - value)));
      }
    });
    return kept;
  }

  function triangles({ size, points, levels }) {
    const [rows, columns] = size,
      out = [];
    const corner = (i, j) => {
      const n = i * columns + j;
      return { point: points.slice(3 * n, 3 * n + 3), level: levels[n] };
    };
    for (let i = 0; i + 1 < rows; i++) {
      for (let j = 0; j + 1 < columns; j++) {
        const [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        for (const three of [
          [a, b, c],
          [a, c, d],
        ]) {
          const kept = clipped(three);
          for (let k = 2; k < kept.length; k++) out.push(...kept[0], ...kept[k - 1], ...kept[k]);
        }
      }
    }
    return new Float32Array(out);
  }

  function remove(j) {
    if (!shown[j]) return;
    shown[j].removeFromParent();
    shown[j].geometry.dispose();
    shown[j].dispose();
    shown[j] = null;
  }

  return {
    show(patterns) {
      // Paths are drawn after the pattern, which would cover them.
      for (const { drawn } of Object.values(gears.flanks)) {
        for (const { all } of drawn) {
          all.material.transparent = true;
          all.renderOrder = 13;
        }
      }
      gears.members.forEach((member, j) => {
        remove(j);
        if (!patterns) return;
        const geometry = new T.BufferGeometry(),
          turn = new T.Matrix4();
        geometry.setAttribute("position", new T.BufferAttribute(triangles(patterns[j].patch), 3));
        const mesh = new T.InstancedMesh(geometry, material, member.teeth);
        for (let k = 0; k < member.teeth; k++) mesh.setMatrixAt(k, turn.makeRotationZ(k * member.pitch));
        mesh.frustumCulled = false;
        mesh.renderOrder = 12; // after both gears
        mesh.layers.set(gears.over);
        member.spin.add(mesh);
        shown[j] = mesh;
      });
    },
    recolour(colour) {
      material.color.set(colour);
    },
  };
};
