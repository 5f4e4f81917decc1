// The window: controls, messages to and from the server, history, and what is shown.
//
// The page computes nothing. It sends the values of all controls with a number, and shows the newest answer.
// After each stage of an answer is drawn, `document` receives an event `explored` with its number, its stage,
// and the time of the calculation.
"use strict";

(async function () {
  const find = (id) => document.getElementById(id);
  const panels = window.beveloidPanels;
  const data = await (await fetch("data.json")).json();
  const memory = `explore-pair ${location.pathname}`;
  const LEVELS = { error: "The pair does not work.", unknown: "Something could not be computed.",
    warning: "The pair may fail in use.", note: "No warnings." };
  const ORDER = Object.keys(LEVELS);
  const REASONS = { refused: "Value refused", jammed: "The pair jams", "no contact": "No contact", "not computed": "Not computed" };

  let values = { ...data.values, ...remembered() };
  let history = [],
    committed = { ...values };
  let sent = 0,
    shown = 0, // numbers of the last message and of the motion that is shown
    judged = false; // whether all remarks are shown
  let now = null,
    start = null; // results that are shown, and those of the start
  let stages = [],
    valid = []; // answers that are shown, one for each stage, and those of the last values that passed all stages
  let comparing = false,
    asked = 0, // number of the last request for the start
    compared = {}; // settings of this request

  document.title = `${data.name} \u2013 explore-pair`;
  find("name").textContent = data.name;

  function remembered() {
    try {
      return JSON.parse(sessionStorage.getItem(memory)) ?? {};
    } catch {
      return {};
    }
  }

  function remember() {
    try {
      sessionStorage.setItem(memory, JSON.stringify(values));
    } catch {
      // A browser without storage forgets the values on reload.
    }
  }

  /* ---- controls ---- */

  const inputs = {};

  function make(tag, properties, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(properties)) {
      if (name in made) made[name] = value;
      else made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  }

  function row(control) {
    const id = `value-${control.name.replaceAll(".", "-")}`;
    const number = make("input", { type: "number", id, step: "any" });
    const slider = make("input", { type: "range", min: control.low, max: control.high, step: control.step });
    slider.setAttribute("aria-label", `${control.label}, ${control.unit}`);
    for (const input of [number, slider]) {
      input.addEventListener("input", () => {
        if (input.value === "") return; // while a number is being typed
        change(control.name, Number(input.value), input);
      });
      input.addEventListener("change", commit);
    }
    inputs[control.name] = { number, slider, unit: control.unit };
    const unit = make("span", { className: "unit" }, control.unit);
    return make("div", { className: "row" }, make("label", { htmlFor: id }, control.label), number, unit, slider);
  }

  function choice(name, text, options) {
    const select = make("select", { id: `value-${name}` });
    for (const [value, words] of Object.entries(options)) select.append(make("option", { value }, words));
    inputs[name] = { select };
    return make("div", { className: "row two" }, make("label", { htmlFor: select.id }, text), select);
  }

  function group(title, open, ...children) {
    return make("details", { open }, make("summary", {}, title), ...children);
  }

  const of = (name) => data.controls.filter((control) => control.group === name).map(row);
  const boxes = {};
  for (const place of ["perpendicular", "mesh"]) boxes[place] = make("div", {}, ...of(place));
  const teeth = [];
  for (const member of ["pinion", "gear"]) {
    for (const flank of ["right", "left"]) {
      const rows = of(`${member}.${flank}`);
      const note = make("p", { className: "note" }, "This member has measured flanks or pitches, which cannot be changed.");
      const body = rows.length ? rows : [note];
      const title = `${member === "pinion" ? "Pinion" : "Gear"}, ${flank} flanks`;
      boxes[`${member}.${flank}`] = group(title, false, ...body);
      teeth.push(boxes[`${member}.${flank}`]);
    }
  }
  const flankChoice = choice("flank", "Driving flanks", { right: "right", left: "left" });
  const placeChoice = choice("errors_at", "Measured at", {
    perpendicular: "common perpendicular",
    mesh: "pitch point",
  });
  find("controls").append(
    group("Assembly errors", true, placeChoice, boxes.perpendicular, boxes.mesh),
    group("Contact", true, flankChoice, ...of("contact")),
    ...teeth,
  );
  find("controls").addEventListener("submit", (event) => event.preventDefault());
  inputs.flank.select.addEventListener("change", () => setFlank(inputs.flank.select.value));
  inputs.errors_at.select.addEventListener("change", () => {
    const place = inputs.errors_at.select.value;
    ask(place, ({ values: equivalent }) => {
      Object.assign(values, equivalent, { errors_at: place });
      say("");
      show();
      commit();
      send();
    });
    show(); // the answer sets the place
  });

  // Shows the values that have changed, except in the input that is being used. Every assignment costs time,
  // even that of the same value.
  function show(used = null) {
    const assign = (input, value) => {
      if (input && input !== used && input.value !== value) input.value = value;
    };
    for (const [name, { number, slider, select, unit }] of Object.entries(inputs)) {
      assign(select, values[name]);
      if (!number) continue;
      const text = String(Number(values[name].toPrecision(12)));
      assign(number, text);
      // A value beyond the slider is at its end; the number field has it.
      if (slider.dataset.value === text) continue;
      slider.dataset.value = text;
      assign(slider, String(values[name]));
      slider.setAttribute("aria-valuetext", `${text} ${unit}`);
    }
    boxes.perpendicular.hidden = values.errors_at !== "perpendicular";
    boxes.mesh.hidden = values.errors_at !== "mesh";
    for (const member of ["pinion", "gear"])
      for (const flank of ["right", "left"]) boxes[`${member}.${flank}`].hidden = values.flank !== flank;
    find("undo").disabled = !history.length;
    find("reset").disabled = same(values, data.values);
  }

  const same = (one, other) => Object.keys(one).every((name) => one[name] === other[name]);

  function change(name, value, input) {
    values[name] = value;
    send(); // first, as the server takes longer than the page
    say("");
    show(input);
  }

  // A drag is one step of the history.
  function commit() {
    if (!same(values, committed)) history.push(committed);
    committed = { ...values };
    show();
  }

  function replace(others) {
    values = { ...others };
    committed = { ...values };
    say("");
    show();
    if (view.flank && view.flank() !== values.flank) view.drive(values.flank);
    send();
  }

  function setFlank(flank) {
    if (values.flank === flank) return;
    values.flank = flank;
    say("");
    commit();
    if (view.flank && view.flank() !== flank) view.drive(flank);
    send();
  }

  /* ---- messages ---- */

  const waiting = {};
  let socket = null,
    queued = false, // whether a message was sent in this frame, and whether the values have changed since
    again = false;

  function connect() {
    socket = new WebSocket(`${location.origin.replace("http", "ws")}${location.pathname}socket`);
    socket.addEventListener("open", send);
    socket.addEventListener("message", ({ data: text }) => receive(JSON.parse(text)));
    socket.addEventListener("close", () => {
      verdict("error", "explore-pair has ended: start it again, and open the address that it prints.", []);
      grey(true);
    });
  }

  // At most one message for each frame of the screen; the first is sent at once.
  function send() {
    remember();
    if (queued) return void (again = true);
    if (socket.readyState !== WebSocket.OPEN) return;
    queued = true;
    sent += 1;
    socket.send(JSON.stringify({ kind: "values", id: sent, values }));
    askStart();
    requestAnimationFrame(() => {
      queued = false;
      if (again) send();
    });
    again = false;
  }

  function ask(kind, act) {
    waiting[kind] = act;
    socket.send(JSON.stringify({ kind, values }));
  }

  function receive(answer) {
    if (answer.kind === "failed") return say(answer.reason);
    if (answer.kind === "start") return receiveStart(answer);
    if (answer.kind !== "result") return waiting[answer.kind]?.(answer);
    if (answer.id < shown) return;
    mark(answer.faults ?? []);
    if ((answer.status ?? "solved") !== "solved") {
      shown = answer.id;
      restore();
      const level = answer.status === "not computed" ? "unknown" : "error";
      verdict(level, `${REASONS[answer.status]}: ${answer.reason}`, []);
      judged = false;
      grey(Boolean(now));
    } else if (answer.stage === "motion") {
      shown = answer.id;
      const before = showStage(answer);
      grey(false);
      // Until all remarks are here, those of the previous values remain, so that the window does not jump.
      if (!before || !judged) judge(answer.remarks);
    } else if (answer.id === shown) {
      showStage(answer);
      if (answer.stage === "remarks") {
        valid = stages;
        judge(answer.remarks);
        judged = true;
      }
    }
    drawFigures();
    finished(answer);
  }

  // Shows flanks, motion graph and teeth of a stage. For the first stage, returns the results that were shown
  // before, or null if they were of the other flanks.
  function showStage(answer) {
    const first = answer.stage === "motion",
      before = !first || now?.flank === answer.flank ? now : null; // the other flanks have another pattern
    stages = first ? [answer] : [...stages, answer];
    now = { ...before, ...answer, figures: figuresOf(before, answer) };
    if (first) {
      if (!before) pattern?.show(null);
      drawFlanks();
      drawGraph();
    } else if (answer.stage === "pattern") {
      drawFlanks();
      view.update?.(answer.frames, now.flank, answer.view);
      pattern?.show(answer.patterns);
    }
    return before;
  }

  // Values can fail after their first stages have been shown: shows the last valid values again.
  function restore() {
    if (stages === valid || !valid.length) return;
    valid.forEach(showStage);
    stages = valid;
  }

  // Figures by stage; those of stages that are not here yet keep the previous value.
  function figuresOf(before, { stage, figures }) {
    return { ...before?.figures, [stage]: figures };
  }

  // Asks for the picture of the start with the present flanks, film and torque, once for each of them.
  function askStart() {
    const { flank, film, torque } = values;
    if (!comparing || socket.readyState !== WebSocket.OPEN || same({ flank, film, torque }, compared)) return;
    if (flank !== compared.flank) start = null; // that of the other flanks
    compared = { flank, film, torque };
    asked += 1;
    socket.send(JSON.stringify({ kind: "start", id: asked, values: { ...data.values, ...compared } }));
  }

  function receiveStart(answer) {
    if (answer.id !== asked || (answer.status ?? "solved") !== "solved") return;
    start = { ...(answer.stage === "motion" ? null : start), ...answer, figures: figuresOf(start, answer) };
    draw();
  }

  function finished({ id, stage, seconds, last }) {
    requestAnimationFrame(() =>
      requestAnimationFrame(() => {
        document.dispatchEvent(new CustomEvent("explored", { detail: { id, stage, seconds, last, newest: sent } }));
      }),
    );
  }

  /* ---- what is shown ---- */

  // Texts are replaced only if they have changed, as every change is laid out and painted.
  function write(node, text) {
    if (node.textContent !== text) node.textContent = text;
  }

  function verdict(level, words, remarks) {
    find("verdict").className = `verdict ${level}`;
    write(find("verdict").querySelector(".words"), words);
    const list = find("verdict").querySelector("ul"),
      texts = remarks.map(({ text }) => text);
    if (String([...list.children].map((item) => item.textContent)) === String(texts)) return;
    list.replaceChildren(...texts.map((text) => make("li", {}, text)));
  }

  function judge(remarks) {
    const level = ORDER.find((each) => remarks.some((one) => one.level === each)) ?? "note";
    verdict(level, LEVELS[level], remarks);
  }

  function grey(old) {
    for (const id of ["panels", "figures", "view"]) find(id).classList.toggle("old", old);
  }

  function mark(faults) {
    for (const [name, { number }] of Object.entries(inputs))
      number?.setAttribute("aria-invalid", String(faults.some((fault) => fault.name === name)));
  }

  // Shows the answer to an action. The answer belongs to the values at that time, so that it is removed when a
  // value changes.
  function say(words) {
    write(find("answer"), words);
  }

  function draw() {
    drawFlanks();
    drawGraph();
    drawFigures();
  }

  // A grey picture can have other flanks than the start, which has those of the controls.
  const startOfShown = () => (comparing && start?.flank === now.flank ? start : null);
  const panelWidth = () => Math.max(260, Math.floor(find("panels").clientWidth));

  function drawFlanks() {
    if (!now?.flanks) return;
    const old = startOfShown();
    panels.flanks([find("pinion"), find("gear")], panelWidth(), now.flanks, now.patterns, old?.flanks, old?.patterns);
    find("side").textContent = now.flank === "right" ? "Right flanks, seen from outside." : "Left flanks, seen through the tooth.";
    panels.key(find("flank-key"), ["path", "flank", "edge", "pattern", ...(comparing ? ["start"] : [])]);
  }

  function drawGraph() {
    if (!now?.graph) return;
    panels.graph(find("graph"), panelWidth(), now.graph, startOfShown()?.graph);
    panels.key(find("graph-key"), ["operation", "operationEdge", "change", "alone", "aloneEdge", ...(comparing ? ["start"] : [])]);
  }

  function drawFigures() {
    if (!now?.flanks) return;
    find("figures").classList.toggle("compared", comparing);
    const listed = (figures) => Object.values(figures ?? {}).flat();
    const before = new Map(listed(startOfShown()?.figures).map((figure) => [figure.name, figure]));
    const cell = (figure) => (figure ? `${figure.text.replace("-", "\u2212")} ${figure.unit}` : "");
    const body = find("figures").tBodies[0],
      shownNow = listed(now.figures),
      labels = shownNow.map(({ label }) => label);
    if (String([...body.rows].map((line) => line.cells[0].textContent)) !== String(labels))
      body.replaceChildren(
        ...shownNow.map(({ name, label }) =>
          make("tr", {}, make("th", { scope: "row" }, label),
            make("td", { "data-figure": name }), make("td", { className: "start" })),
        ),
      );
    shownNow.forEach((figure, n) => {
      write(body.rows[n].cells[1], cell(figure));
      write(body.rows[n].cells[2], cell(before.get(figure.name)));
    });
  }

  /* ---- actions ---- */

  function download(name, blob) {
    const link = make("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  const stem = data.name.split(/[\\/]/).at(-1).replace(/\.toml$/i, "");
  find("undo").addEventListener("click", () => {
    if (history.length) replace(history.pop());
  });
  find("reset").addEventListener("click", () => {
    history.push(committed);
    replace(data.values);
  });
  find("compare").addEventListener("click", () => {
    comparing = !comparing;
    find("compare").setAttribute("aria-pressed", String(comparing));
    askStart();
    draw();
  });
  find("save").addEventListener("click", () =>
    ask("save", ({ text }) => {
      download(`${stem}-changed.toml`, new Blob([text], { type: "application/toml" }));
      say(`Saved as ${stem}-changed.toml in the folder of downloads.`);
    }),
  );
  find("command").addEventListener("click", () =>
    ask("command", async ({ line, reason }) => {
      if (reason) return say(`No command line: ${reason}.`);
      try {
        await navigator.clipboard.writeText(line);
        say(`Copied: ${line}`);
      } catch {
        say(line); // a browser may forbid the clipboard
      }
    }),
  );
  find("picture").addEventListener("click", () => picture());

  // Teeth on top, flanks and motion graph below, as one PNG at twice the size of the screen.
  async function picture() {
    const width = Math.max(...["pinion", "gear", "graph"].map((id) => find(id).clientWidth));
    const drawn = view.picture?.(),
      images = drawn ? [[drawn, width, (width * drawn.height) / drawn.width]] : [];
    for (const id of ["pinion", "gear", "graph"]) {
      const svg = find(id).cloneNode(true);
      svg.setAttribute("xmlns", "http://www.w3.org/2000/svg");
      const image = new Image();
      image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg.outerHTML)}`;
      await image.decode();
      images.push([image, Number(svg.getAttribute("width")), Number(svg.getAttribute("height"))]);
    }
    const canvas = make("canvas", { width: 2 * width, height: 2 * images.reduce((sum, [, , height]) => sum + height, 0) });
    const pen = canvas.getContext("2d");
    pen.scale(2, 2);
    pen.fillStyle = panels.colours().paper;
    pen.fillRect(0, 0, canvas.width, canvas.height);
    let top = 0;
    for (const [image, wide, high] of images) {
      pen.drawImage(image, 0, top, wide, high);
      top += high;
    }
    canvas.toBlob((blob) => download(`${stem}.png`, blob), "image/png");
  }

  document.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === "z" && event.target.type !== "number") find("undo").click();
  });

  /* ---- start ---- */

  const view = window.beveloidView(find("view"), data.view);
  const pattern = view.gears && window.beveloidPattern(view.gears); // without WebGL there is no scene
  view.drive?.(values.flank);
  find("view").addEventListener("flankchange", ({ detail }) => setFlank(detail));
  function recolour() {
    pattern?.recolour(panels.colours().accent);
    draw();
  }
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
  new ResizeObserver(draw).observe(find("panels"));
  window.exploreView = view; // for tests
  recolour();
  show();
  connect();
})();
