// Contact pattern on the teeth of the 3D view: window.beveloidPattern(gears).
"use strict";

window.beveloidPattern = function (gears) {
  const T = window.THREE;
  const material = new T.MeshBasicMaterial({
    transparent: true,
    opacity: 0.5,
    depthWrite: false,
    forceSinglePass: true, // otherwise both sides are compiled anew for each picture
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -2,
  });
  const shown = [null, null];

  // The part of a polygon in which the level, linear along its sides, is negative.
  function clipped(corners) {
    const kept = [];
    corners.forEach((a, n) => {
      const b = corners[(n + 1) % corners.length];
      if (a.level < 0) kept.push(a.point);
      if (a.level < 0 !== b.level < 0) {
        const share = a.level / (a.level - b.level);
        kept.push(a.point.map((value, k) => value + share * (b.point[k] - value)));
      }
    });
    return kept;
  }

  // Triangles of the part of a grid in which the level is negative. Cells that lie inside are joined along
  // their row as far as the flank is straight there within a tolerance in mm: every tooth has these triangles.
  function triangles({ size, points, levels, tolerance }) {
    const [rows, columns] = size,
      positions = [],
      faces = [];
    const corner = (i, j) => {
      const n = i * columns + j;
      return { point: points.slice(3 * n, 3 * n + 3), level: levels[n] };
    };
    const inside = (i, j) => levels[i * columns + j] < 0 && levels[(i + 1) * columns + j] < 0;

    // Distance in mm between a row of points and the line between its ends, in the middle.
    function bend(i) {
      const middle = columns >> 1,
        share = middle / (columns - 1);
      const [a, b, c] = [0, middle, columns - 1].map((j) => corner(i, j).point);
      return Math.hypot(...b.map((value, k) => value - a[k] - share * (c[k] - a[k])));
    }

    function cell(i, first, last) {
      const corners = [corner(i, first), corner(i + 1, first), corner(i + 1, last), corner(i, last)];
      const kept = clipped(corners),
        before = positions.length / 3;
      positions.push(...kept.flat());
      for (let k = 2; k < kept.length; k++) faces.push(before, before + k - 1, before + k);
    }

    // Joined cells end at the same columns in all rows, so that no gaps open between full rows. The distance
    // between arc and chord is proportional to the square of the length.
    const parts = Math.ceil(Math.sqrt(Math.max(bend(0), bend(rows - 1)) / tolerance)),
      length = Math.max(1, Math.floor((columns - 1) / Math.max(1, parts)));
    for (let i = 0; i + 1 < rows; i++) {
      for (let j = 0, last; j + 1 < columns; j = last) {
        last = j + 1;
        while (inside(i, j) && inside(i, last) && last % length && last + 1 < columns && inside(i, last + 1)) last += 1;
        cell(i, j, last);
      }
    }
    const geometry = new T.BufferGeometry();
    geometry.setAttribute("position", new T.BufferAttribute(new Float32Array(positions), 3));
    return geometry.setIndex(faces);
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
        const turn = new T.Matrix4(),
          mesh = new T.InstancedMesh(triangles(patterns[j].patch), material, member.teeth);
        for (let k = 0; k < member.teeth; k++) mesh.setMatrixAt(k, turn.makeRotationZ(k * member.pitch));
        mesh.frustumCulled = false;
        mesh.renderOrder = 12; // after both gears
        mesh.layers.set(gears.over);
        // Only a see-through gear shows patterns from behind.
        mesh.onBeforeRender = () => {
          material.side = gears.members.some(({ display }) => display === "glass") ? T.DoubleSide : T.FrontSide;
        };
        member.spin.add(mesh);
        shown[j] = mesh;
      });
    },
    recolour(colour) {
      material.color.set(colour);
    },
  };
};
