// The view of the pair in mesh: window.beveloidView(container, data) with the data of view_data.py.
//
// Styles are in viewer.css. It takes the page's colours from --panel, --paper, --ink, --muted, --line,
// --pinion, --gear, --path and --accent, also after a `themechange` event on window, and draws only when
// something has changed.
"use strict";

window.beveloidView = function (container, data) {
  const T = window.THREE;
  const VIEWS = {
    pair: ["Pair", "solid", "solid"],
    section: ["Section at contact", "solid", "solid"],
    pinion: ["Pinion flank", "solid", "hidden"],
    gear: ["Gear flank", "hidden", "solid"],
  };
  const PITCHES = 2; // the slider's reach either way
  const SPEED = 0.3; // pitches a second
  const VISIBLE = 0.3; // pixels; teeth that are off by less stay where they are

  function element(tag, properties, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(properties)) {
      if (name in made) made[name] = value;
      else made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  }

  const trial = document.createElement("canvas").getContext("webgl2");
  if (!trial) {
    container.append(
      element("p", {}, "The 3D view needs WebGL 2, which this browser does not provide."),
    );
    return {
      setRoll() {},
      roll: () => data.roll,
      camera: () => [],
      dispose: () => container.replaceChildren(),
    };
  }
  trial.getExtension("WEBGL_lose_context")?.loseContext();

  const gears = window.beveloidGears(data),
    { members, flanks } = gears,
    [pinion] = members;
  let roll = data.roll,
    flank = !flanks.right.path && flanks.left.path ? "left" : "right";
  let view = "pair",
    moved = false; // moved: by the user, so that we leave the camera alone

  /* ---- contents of the page ---- */

  const renderer = new T.WebGLRenderer({ antialias: true, alpha: true }),
    canvas = renderer.domElement;
  const kept = window.beveloidKeptTeeth(renderer, gears);
  renderer.localClippingEnabled = true;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute(
    "aria-label",
    "Pinion and gear in mesh. Arrow keys rotate the view, plus and minus zoom.",
  );
  const stage = element("div", { className: "bv-stage" }, canvas);
  const play = element(
    "button",
    { type: "button", className: "bv-play", onclick: () => (playing ? pause() : start()) },
    "Play",
  );
  const slider = element("input", {
    type: "range",
    min: -PITCHES,
    max: PITCHES,
    step: 0.01,
    "aria-label": "Roll of the pinion",
  });
  const rollText = element("output", { className: "bv-roll" }),
    contactText = element("p", { className: "bv-contact" });
  const noteText = element("p", { className: "bv-note" });

  function choice(title, names, act) {
    const buttons = Object.entries(names).map(([value, name]) =>
      element("button", { type: "button", value, onclick: () => act(value) }, name),
    );
    const mark = (value) =>
      buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.value === value)));
    return { set: element("fieldset", { "aria-label": title }, ...buttons), mark };
  }

  const named = Object.entries(VIEWS).map(([key, [name]]) => [key, name]);
  const viewChoice = choice("View", Object.fromEntries(named), look);
  const flankChoice = choice("Driving flanks", { right: "Right flanks", left: "Left flanks" }, drive);
  const displays = members.map((member, j) => {
    const options = ["solid", "glass", "hidden"].map((value) =>
      element("option", { value }, value === "glass" ? "see-through" : value),
    );
    return element("select", { onchange: () => show(j, displays[j].value) }, ...options);
  });
  const wayLabels = members.map(({ name }, j) => {
    const swatch = element("span", { className: "bv-swatch", style: `background: var(--${name})` });
    return element("label", {}, swatch, `${name} `, displays[j]);
  });
  const controlsBox = element(
    "div",
    { className: "bv-controls" },
    element("div", {}, viewChoice.set, flankChoice.set),
    element("div", {}, play, slider, rollText),
    contactText,
    element("div", {}, ...wayLabels),
    noteText,
  );
  container.append(stage, controlsBox);

  const labels = members.flatMap((member, j) =>
    member.ends.map((name, end) => {
      const node = element(
        "span",
        { className: "bv-label", "aria-hidden": "true" },
        `${member.name} ${name}`,
      );
      stage.append(node);
      return { j, end, node };
    }),
  );

  /* ---- at a roll ---- */

  const signed = (value) =>
    value
      .toFixed(2)
      .replace(/^-(0\.00)$/, "$1")
      .replace("-", "\u2212");
  const gapText = (mm) =>
    mm < 0.1 ? `${Number((1000 * mm).toPrecision(2))} \u00b5m` : `${Number(mm.toPrecision(2))} mm`;

  function words(found, edge) {
    const touching = found.filter((one) => one.touches).length,
      said = [];
    if (edge) said.push(["edge", `The edge at the ${edge.name} touches first, off the path.`]);
    if (touching === 1) said.push(["touching", "One tooth pair touches on its path."]);
    if (touching > 1) said.push(["touching", `${touching} tooth pairs touch on their paths.`]);
    for (const one of found.filter((each) => !each.touches))
      said.push(["clear", `A tooth pair on its path has a gap of ${gapText(one.gap)}.`]);
    if (!said.length) return flanks[flank].path ? ["No tooth pair is on its path."] : [];
    return said.flatMap(([kind, text]) => [
      element("span", { className: `bv-${kind}`, "aria-hidden": "true" }, "\u25cf "),
      `${text} `,
    ]);
  }

  function pose() {
    const { found, edge } = gears.pose(roll, flank, view === "section");
    const pitches = (roll - data.roll) / pinion.pitch,
      text = `${signed((roll * 180) / Math.PI)}\u00b0, ${signed(pitches)} pitches`;
    slider.value = String(pitches);
    slider.setAttribute("aria-valuetext", text);
    rollText.textContent = `pinion\u2019s roll ${text}`;
    contactText.replaceChildren(...words(found, edge));
    draw();
  }

  function show(j, display) {
    displays[j].value = display;
    gears.show(j, display, view === "section");
    draw();
  }

  function drive(name) {
    flank = name;
    flankChoice.mark(name);
    container.dispatchEvent(new CustomEvent("flankchange", { detail: name }));
    const { cycle, note } = flanks[name];
    const posed = {
      path: "The gear is positioned by the path of contact alone.",
      unmodified: "The gear is positioned as without modification.",
    }[cycle.by];
    noteText.textContent = [...members.map((member) => member.note), note, posed].filter(Boolean).join(" ");
    pose();
    if (!moved) fit();
  }

  /* ---- from where it is looked at ---- */

  const camera = new T.PerspectiveCamera(22, 1, 1, 1000);
  gears.scene.add(camera, new T.AmbientLight("white", 0.75));
  // Lights go with the camera, so that no side is ever dark: from the upper left, from the eye, from the right.
  for (const [x, y, z, strength] of [
    [-1, 0.9, 0.6, 1.5],
    [0.2, -0.3, 1, 1.4],
    [1, -0.4, 0.6, 0.4],
  ]) {
    const light = new T.DirectionalLight("white", strength);
    light.position.set(x, y, z);
    camera.add(light, light.target);
  }
  const everything = members.flatMap(gears.rims);
  const middle = everything
    .reduce((sum, point) => sum.add(point), new T.Vector3())
    .divideScalar(everything.length);
  const radius = Math.max(...everything.map((point) => point.distanceTo(middle)));
  let orbit = null;

  // Towards the viewer, up, and the points to be seen.
  function aim() {
    const there = gears.middleOf(flanks[flank], roll),
      member = members.find(({ name }) => name === view) ?? pinion;
    const radial = gears.radialOf(member, there.point);
    if (view === "pair")
      return { back: new T.Vector3(0.5, -0.52, -0.7), up: new T.Vector3(0, -1, 0), points: everything };
    if (view === "section") {
      const along = gears.alongTooth(there),
        reach = 3.2 * data.module;
      const points = [radial, there.normal].flatMap((way) =>
        [reach, -reach].map((size) => there.point.clone().addScaledVector(way, size)),
      );
      return { back: along, up: along.clone().cross(radial), points }; // from -z, pinion on the left
    }
    // Look perpendicular to the flank, but inclined towards the tip, so that the next tooth does not hide the
    // flank.
    const square = there.normal.clone().addScaledVector(radial, -there.normal.dot(radial)).normalize();
    const back = square.multiplyScalar(member === pinion ? 0.75 : -0.75).addScaledVector(radial, 0.66);
    return { back, up: radial, points: gears.corners(member, flank, there.pair) ?? gears.rims(member) };
  }

  // The nearest place from which all of that is seen.
  function fit() {
    const { back, up, points } = aim(),
      z = back.clone().normalize(),
      x = up.clone().cross(z).normalize(),
      y = z.clone().cross(x);
    const centre = new T.Vector3();
    for (const way of [x, y, z]) {
      const along = points.map((point) => point.dot(way));
      centre.addScaledVector(way, (Math.min(...along) + Math.max(...along)) / 2);
    }
    const tall = Math.tan((camera.fov * Math.PI) / 360) / (view === "pair" ? 1.12 : 1.25),
      wide = tall * camera.aspect;
    const needed = points.map((point) => {
      const from = point.clone().sub(centre);
      return from.dot(z) + Math.max(Math.abs(from.dot(x)) / wide, Math.abs(from.dot(y)) / tall);
    });
    camera.up.copy(y);
    camera.position.copy(centre).addScaledVector(z, Math.max(...needed));
    orbit?.dispose();
    orbit = new T.OrbitControls(camera, canvas); // anew, as it takes its axis from camera.up only once
    orbit.target.copy(centre);
    Object.assign(orbit, { minDistance: 2 * data.module, maxDistance: 8 * radius });
    orbit.touches = { ONE: T.TOUCH.ROTATE, TWO: T.TOUCH.DOLLY_ROTATE };
    canvas.style.touchAction = "pan-y"; // one finger up or down scrolls the page
    orbit.update();
    orbit.addEventListener("start", () => (moved = true));
    orbit.addEventListener("change", draw);
    moved = false;
    draw();
  }

  function look(name) {
    view = name;
    viewChoice.mark(name);
    members.forEach((_, j) => show(j, VIEWS[name][j + 1]));
    pose();
    fit();
  }

  /* ---- drawing ---- */

  // Beside the ends of the flank that is looked at, or on the rims, both ends apart.
  function labelPlace({ j, end }) {
    const member = members[j];
    if (member.display === "hidden" || view === "section") return null;
    if (view === member.name && member.tooth) {
      const at = gears.corners(member, flank, gears.middleOf(flanks[flank], roll).pair);
      const ends = [0, 1].map((n) => at[2 * n].lerp(at[2 * n + 1], 0.5));
      return ends[end].addScaledVector(
        ends[end]
          .clone()
          .sub(ends[1 - end])
          .normalize(),
        0.1 * member.half_width,
      );
    }
    const [up, right] = [
      [0, 1, 0],
      [1, 0, 0],
    ].map((way) => new T.Vector3(...way).applyQuaternion(camera.quaternion));
    const side = member.axis.dot(right) > 0 === (end === 1) ? 0.35 : -0.35;
    return gears.onRim(member, end, up.addScaledVector(right, side), data.module);
  }

  function placeLabels(width, height) {
    for (const one of labels) {
      const place = labelPlace(one)?.project(camera),
        x = (place?.x + 1) * 0.5 * width,
        y = (1 - place?.y) * 0.5 * height;
      one.node.hidden = !(place && place.z < 1 && x > 0 && x < width && y > 0 && y < height);
      if (one.node.hidden) continue;
      const wide = one.node.offsetWidth,
        left = Math.min(width - wide, Math.max(0, x - wide / 2));
      one.node.style.transform = `translate(${left}px, ${y}px) translate(0, -100%)`;
    }
  }

  let pending = 0;
  function draw() {
    pending ||= requestAnimationFrame(render);
  }

  function render() {
    pending = 0;
    const away = camera.position.distanceTo(middle),
      width = stage.clientWidth,
      height = stage.clientHeight;
    camera.near = Math.max(away - radius, 0.02 * away, 0.1 * data.module);
    camera.far = away + 1.5 * radius;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    gears.sizeDots(camera, height);
    gears.moveTeeth((VISIBLE * camera.near * 2 * Math.tan((camera.fov * Math.PI) / 360)) / height);
    kept.render(camera, looks, playing || view === "section"); // a section moves with the contact
    placeLabels(width, height);
  }

  const pen = element("canvas", { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });
  function colour(name) {
    // Painted and read, as CSS has more ways to write a colour than three.js reads.
    pen.fillStyle = getComputedStyle(container).getPropertyValue(`--${name}`).trim() || "gray";
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b] = pen.getImageData(0, 0, 1, 1).data;
    return new T.Color().setRGB(r / 255, g / 255, b / 255, T.SRGBColorSpace);
  }

  let looks = 0; // how often the colours have changed
  function recolour() {
    looks += 1;
    gears.recolour(colour);
    draw();
  }

  function resize() {
    const width = container.clientWidth;
    if (!width) return;
    stage.style.height = `${Math.round(Math.min(520, Math.max(320, 0.62 * width)))}px`;
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    renderer.setSize(stage.clientWidth, stage.clientHeight);
    camera.aspect = stage.clientWidth / stage.clientHeight;
    if (moved) draw();
    else fit();
  }

  /* ---- what the user does ---- */

  let playing = 0;
  function start() {
    play.textContent = "Pause";
    advance(performance.now());
  }

  function pause() {
    cancelAnimationFrame(playing);
    playing = 0;
    play.textContent = "Play";
  }

  function advance(before) {
    playing = requestAnimationFrame((now) => {
      // The pinion drives: it turns one way with right flanks, the other way with left ones.
      const step = (flank === "left" ? -SPEED : SPEED) * Math.max(0, Math.min(0.1, (now - before) / 1000));
      const pitches = (roll - data.roll) / pinion.pitch + step,
        back = 2 * PITCHES * Math.round(pitches / (2 * PITCHES));
      roll = data.roll + (pitches - back) * pinion.pitch;
      pose();
      advance(now);
    });
  }

  slider.addEventListener("input", () => {
    pause();
    roll = data.roll + Number(slider.value) * pinion.pitch;
    pose();
  });

  const KEYS = {
    ArrowLeft: () => orbit.rotateLeft(0.1),
    ArrowRight: () => orbit.rotateLeft(-0.1),
    ArrowUp: () => orbit.rotateUp(0.1),
    ArrowDown: () => orbit.rotateUp(-0.1),
    "+": () => orbit.dollyIn(0.9),
    "=": () => orbit.dollyIn(0.9),
    "-": () => orbit.dollyOut(0.9),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!KEYS[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    moved = true;
    KEYS[event.key]();
  });
  canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
  // The wheel scrolls the page, unless the view has the focus or Ctrl is held.
  const wheel = (event) => event.ctrlKey || document.activeElement === canvas || event.stopPropagation();
  stage.addEventListener("wheel", wheel, { capture: true, passive: true });

  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const sizes = new ResizeObserver(resize),
    seen = new IntersectionObserver(([now]) => now.isIntersecting || pause());
  dark.addEventListener("change", recolour);
  window.addEventListener("themechange", recolour);
  sizes.observe(container);
  seen.observe(stage);
  recolour();
  resize();
  drive(flank);
  look(view);

  function setRoll(value) {
    pause();
    roll = value;
    pose();
  }

  function dispose() {
    pause();
    cancelAnimationFrame(pending);
    sizes.disconnect();
    seen.disconnect();
    dark.removeEventListener("change", recolour);
    window.removeEventListener("themechange", recolour);
    orbit.dispose();
    gears.dispose();
    kept.dispose();
    renderer.dispose();
    container.replaceChildren();
  }

  // Shows other frames and another path of one flank at the present roll.
  function update(frames, name, given) {
    gears.update(frames, name, given);
    if (name === flank) drive(name);
  }

  // The canvas just after it was drawn, as a browser clears it later.
  function picture() {
    render();
    return canvas;
  }

  return {
    setRoll,
    roll: () => roll,
    camera: () => [...camera.position, ...orbit.target],
    flank: () => flank,
    drive,
    update,
    draw,
    picture,
    gears,
    dispose,
  };
};
