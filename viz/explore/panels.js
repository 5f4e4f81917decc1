// Flattened flanks and motion graph as SVG: window.beveloidPanels.
//
// Colours are written into the elements, so that the pictures can be downloaded. Positions are those of
// panels.py: mm on the flanks, pitches and arcsec in the graph.
"use strict";

window.beveloidPanels = (function () {
  const FONT = "13px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

  function colours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["ink", "muted", "line", "path", "accent", "paper"];
    return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  }

  function polyline(points, place) {
    // A missing point interrupts the line.
    let text = "",
      broken = true;
    for (const point of points) {
      if (point[0] === null || point[1] === null) {
        broken = true;
        continue;
      }
      const [x, y] = place(point);
      text += `${broken ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`;
      broken = false;
    }
    return text;
  }

  // Closed polygons, without points that are nearer to each other than a pixel.
  function rings(all, place) {
    let text = "";
    for (const ring of all) {
      let [last, count] = [[-9, -9], 0];
      for (const point of ring.map(place)) {
        if (Math.abs(point[0] - last[0]) + Math.abs(point[1] - last[1]) < 1.2) continue;
        text += `${count++ ? "L" : "M"}${point[0].toFixed(1)} ${point[1].toFixed(1)}`;
        last = point;
      }
      if (count) text += "Z";
    }
    return text;
  }

  const label = (x, y, text, colour, anchor = "middle") =>
    `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" fill="${colour}" text-anchor="${anchor}">${text}</text>`;

  function write(svg, width, height, body) {
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("width", width);
    svg.setAttribute("height", height);
    svg.setAttribute("style", `font: ${FONT}`);
    svg.innerHTML = body;
  }

  // A round step of about a fifth of a length.
  function stepOf(length) {
    const power = 10 ** Math.floor(Math.log10(length / 5));
    return power * [1, 2, 5, 10].find((n) => n * power >= length / 5.01);
  }

  const numeral = (value) => String(Number(value.toPrecision(6))).replace("-", "\u2212");

  function ticks(low, high) {
    const step = stepOf(high - low),
      count = Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1;
    return Array.from({ length: Math.max(0, count) }, (_, n) => (Math.ceil(low / step - 1e-9) + n) * step);
  }

  // A flank of one member; `scale` in pixels per mm.
  function flank(svg, width, scale, now, bands, start, startBands) {
    const c = colours();
    if (!now) return write(svg, width, 24, label(4, 16, "This flank does not reach its tip.", c.muted, "start"));
    const x = now.outline.map((point) => point[0]),
      y = now.outline.map((point) => point[1]);
    const [left, right, low, high] = [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)];
    const top = 30,
      bottom = top + (high - low) * scale,
      shift = width / 2 - ((left + right) / 2) * scale;
    const place = ([px, py]) => [shift + px * scale, top + (high - py) * scale];
    const at = (px) => shift + px * scale;
    let body = `<path d="${polyline(now.outline, place)}Z" fill="${c.muted}" fill-opacity="0.16" stroke="${c.muted}"/>`;
    for (const band of bands ?? [])
      body += `<path d="${rings(band, place)}" fill="${c.accent}" fill-opacity="0.22" fill-rule="evenodd"/>`;
    if (start && startBands?.length)
      body += `<path d="${rings(startBands.at(-1), place)}" fill="none" stroke="${c.accent}" stroke-dasharray="2 3"/>`;
    if (start)
      body += `<path d="${polyline(start.path, place)}" fill="none" stroke="${c.muted}" stroke-width="2" stroke-dasharray="6 4"/>`;
    body += `<path d="${polyline(now.path, place)}" fill="none" stroke="${c.path}" stroke-width="2.5"/>`;
    for (const [px, py, edge] of now.contacts) {
      if (px === null || py === null) continue;
      const [cx, cy] = place([px, py]);
      body += `<circle cx="${cx.toFixed(1)}" cy="${cy.toFixed(1)}" r="3.4" fill="${edge ? c.paper : c.path}" stroke="${c.path}" stroke-width="1.6"/>`;
    }
    const middle = (top + bottom) / 2 + 4;
    body += label(at(left), 14, `${now.member}`, c.ink, "start") + label(width / 2, top - 6, "tip", c.muted);
    body += label(at(left) - 6, middle, now.back, c.muted, "end") + label(at(right) + 6, middle, now.front, c.muted, "start");
    const axis = bottom + 8;
    body += `<path d="M${at(left)} ${axis}H${at(right)}" stroke="${c.muted}"/>`;
    for (const tick of ticks(left, right)) {
      body += `<path d="M${at(tick)} ${axis}v4" stroke="${c.muted}"/>`;
      body += label(at(tick), axis + 17, numeral(tick), c.muted);
    }
    body += label(at(right) + 6, axis + 17, "mm", c.muted, "start");
    svg.setAttribute("aria-label", `Flank of the ${now.member} with path of contact, first contacts and pattern`);
    write(svg, width, Math.ceil(axis + 22), body);
  }

  // Both flanks at the same scale.
  function flanks(svgs, width, now, patterns, start, startPatterns) {
    const spans = now.filter(Boolean).map((one) => {
      const x = one.outline.map((point) => point[0]);
      return Math.max(...x) - Math.min(...x);
    });
    const scale = (width - 104) / Math.max(...spans, 1);
    svgs.forEach((svg, j) =>
      flank(svg, width, scale, now[j], patterns?.[j].bands, start?.[j], startPatterns?.[j].bands),
    );
  }

  function graph(svg, width, now, start) {
    const c = colours(),
      height = 230,
      [left, right, top, bottom] = [54, width - 54, 18, height - 38];
    const limits = [now, start].filter(Boolean).map((one) => one.limits);
    const low = Math.min(...limits.map((one) => one[0])),
      high = Math.max(...limits.map((one) => one[1]));
    const px = (pitch) => left + (pitch / 2) * (right - left),
      py = (error) => top + ((high - error) / (high - low)) * (bottom - top);
    // Points outside the frame are left out; only a point next to one inside is kept and moved to the frame.
    // Long dashed lines, and clipped lines, take seconds to draw without a graphics card.
    const within = (value, low, high) => Math.min(Math.max(value, low), high);
    const line = (x, y, shown = () => true) => {
      const inside = x.map((value, n) => y[n] !== null && value >= 0 && value <= 2 && y[n] >= low && y[n] <= high);
      const points = x.map((value, n) => {
        if (!shown(n) || y[n] === null) return [null, null];
        if (inside[n]) return [px(value), py(y[n])];
        const m = inside[n - 1] ? n - 1 : n + 1;
        if (!inside[m]) return [null, null];
        const limit = within(y[n], low, high),
          share = limit === y[n] ? 1 : (limit - y[m]) / (y[n] - y[m]);
        return [within(px(x[m] + share * (value - x[m])), left, right), py(limit)];
      });
      return polyline(points, (point) => point);
    };
    let body = "";
    for (const tick of ticks(low, high)) {
      body += `<path d="M${left} ${py(tick)}H${right}" stroke="${c.line}"/>`;
      body += label(left - 6, py(tick) + 4, numeral(tick), c.muted, "end");
    }
    const um = now.um_per_arcsec;
    for (const tick of ticks(low * um, high * um))
      body += label(right + 6, py(tick / um) + 4, numeral(tick), c.muted, "start");
    for (const tick of [0, 0.5, 1, 1.5, 2]) body += label(px(tick), bottom + 16, numeral(tick), c.muted);
    body += label((left + right) / 2, height - 5, "pinion roll, pitches", c.muted);
    body += label(4, 11, "arcsec", c.muted, "start") + label(width - 4, 11, "\u00b5m at the pitch circle", c.muted, "end");
    body += `<g fill="none">`;
    const next = (edge, n) => edge[n] || edge[n - 1] || edge[n + 1];
    for (let pair = -now.reach; pair <= now.reach + 2; pair++) {
      const x = now.pitches.map((value) => value + pair);
      body += `<path d="${line(x, now.alone, (n) => !now.alone_edge[n])}" stroke="${c.muted}"/>`;
      body += `<path d="${line(x, now.alone, (n) => next(now.alone_edge, n))}" stroke="${c.muted}" stroke-dasharray="1.5 3"/>`;
    }
    for (const pitch of [0, 1]) {
      const along = (values) => values.map((_, n) => pitch + n / (values.length - 1));
      if (start)
        body += `<path d="${line(along(start.operation), start.operation)}" stroke="${c.muted}" stroke-width="2" stroke-dasharray="6 4"/>`;
      const x = along(now.operation);
      body += `<path d="${line(x, now.operation)}" stroke="${c.accent}" stroke-width="2.2"/>`;
      body += `<path d="${line(x, now.operation, (n) => now.operation_edge[n])}" stroke="${c.path}" stroke-width="4.5"/>`;
      for (const [at, error] of now.changes)
        if (at !== null && at + pitch <= 2) body += `<circle cx="${px(at + pitch)}" cy="${py(error)}" r="3.5" fill="${c.ink}"/>`;
    }
    body += `</g><path d="M${left} ${top}V${bottom}H${right}V${top}" fill="none" stroke="${c.muted}"/>`;
    svg.setAttribute("aria-label", "Motion graph: transmission error over two pitches of the pinion");
    write(svg, width, height, body);
  }

  const SAMPLES = {
    path: ["path of contact", (c) => `<path d="M0 5H26" stroke="${c.path}" stroke-width="2.5"/>`],
    flank: ["first contact on the flank", (c) => `<circle cx="13" cy="6" r="3.6" fill="${c.path}"/>`],
    edge: ["first contact on an edge", (c) => `<circle cx="13" cy="6" r="3.6" fill="${c.paper}" stroke="${c.path}" stroke-width="1.6"/>`],
    pattern: ["contact pattern", (c) => `<path d="M0 0H26V12H0Z" fill="${c.accent}" fill-opacity="0.4"/>`],
    alone: ["one tooth pair alone", (c) => `<path d="M0 6H26" stroke="${c.muted}"/>`],
    aloneEdge: ["one pair, on an edge", (c) => `<path d="M0 6H26" stroke="${c.muted}" stroke-dasharray="1.5 3"/>`],
    operation: ["in operation", (c) => `<path d="M0 6H26" stroke="${c.accent}" stroke-width="2.2"/>`],
    operationEdge: ["in operation, on an edge", (c) => `<path d="M0 6H26" stroke="${c.path}" stroke-width="4.5"/>`],
    change: ["change of tooth pair", (c) => `<circle cx="13" cy="6" r="3.5" fill="${c.ink}"/>`],
    start: ["start", (c) => `<path d="M0 6H26" stroke="${c.muted}" stroke-width="2" stroke-dasharray="6 4"/>`],
  };

  function key(node, names) {
    const c = colours(),
      sample = (name) => `<svg viewBox="0 0 26 12" aria-hidden="true">${SAMPLES[name][1](c)}</svg>`,
      html = names.map((name) => `<span>${sample(name)}${SAMPLES[name][0]}</span>`).join("");
    if (node.drawn !== html) node.innerHTML = node.drawn = html; // otherwise it would be laid out again
  }

  return { flanks, graph, key, colours };
})();
