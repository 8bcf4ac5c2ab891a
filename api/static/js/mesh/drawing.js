// Paints a body on a canvas: regions or contours, deformed as wanted, with its mesh, outline and vectors.
import { translate } from "../language.js";
import { COLOURS, tickText, ticks } from "../scales.js";
import { colour, palette } from "../plot.js";
import { PIECES, between, roundDown, thickness } from "./geometry.js";

export const INTERFACE = "--series-2"; // its colour
const LONGEST_ARROW = 0.14;
const EDGE = 42, // px between the lower edge and what is drawn for scale, for the axis below it
  BETWEEN = 90,
  TICK = 6,
  THIN = 3; // px: lines around thinner triangles would hide their colour

/** Colour of a band, of a number of bands. */
export function bandColour(band, count) {
  return COLOURS[Math.round((band / Math.max(1, count - 1)) * (COLOURS.length - 1))];
}

export function regionColours(count) {
  const found = palette();
  return Array.from({ length: count }, (_, i) =>
    found[i % found.length].replace("rgb(", "rgba(").replace(")", `, ${i < found.length ? 0.45 : 0.25})`),
  );
}

/**
 * Paint. `view`: {mesh, places (drawn positions), outline, shown: "regions" or {levels, value(e, k)}, options:
 * {lines, outline, vectors, points}, vectors, unit}; `map([x, y])`: pixels; `size`: [width, height].
 */
export function paint(context, view, map, size) {
  const pixels = view.places.map(map);
  context.clearRect(0, 0, ...size);
  context.lineJoin = "round";
  if (view.shown === "regions") regions(context, view, pixels);
  else contours(context, view, pixels);
  if (view.options.lines)
    lines(
      context,
      view.mesh.triangles,
      pixels,
      colour("--muted"),
      (view.shown === "regions" ? 0.45 : 0.25) * fineness(view.mesh.triangles, pixels),
    );
  interfaces(context, view.mesh.interfaces, pixels);
  if (view.options.outline) edges(context, view.outline, view.mesh.nodes.map(map), colour("--ink"), [5, 4]);
  if (view.options.points) points(context, view.mesh, pixels);
  if (view.options.vectors) arrows(context, view, map, size);
  axes(context, map, size);
  metres(context, map, size);
}

/** Places in metres along the lower edge and the left one. */
function axes(context, map, [width, height]) {
  const [[x0, y0], [dx, dy]] = [map([0, 0]), [map([1, 0])[0] - map([0, 0])[0], map([0, 0])[1] - map([0, 1])[1]]];
  const on = (low, high, length) => ticks(low, high, "linear", Math.max(2, Math.floor(length / BETWEEN)));
  context.strokeStyle = colour("--ink");
  context.lineWidth = 1;
  context.beginPath();
  const across = on(-x0 / dx, (width - x0) / dx, width).map((x) => [x, x0 + x * dx]);
  const up = on((y0 - height) / dy, y0 / dy, height).map((y) => [y, y0 - y * dy]);
  for (const [, at] of across) line(context, [at, height], [at, height - TICK]);
  for (const [, at] of up) line(context, [0, at], [TICK, at]);
  context.stroke();
  const room = ([, at], length) => at > 30 && at < length - 30;
  for (const one of across)
    if (room(one, width)) label(context, `x = ${tickText(one[0])} m`, one[1], height - TICK - 4);
  for (const one of up)
    if (room(one, height - EDGE)) label(context, `y = ${tickText(one[0])} m`, TICK + 4, one[1] + 4, "left");
}

function line(context, from, to) {
  context.moveTo(...from);
  context.lineTo(...to);
}

/** A length of the body, for scale. */
function metres(context, map, [width, height]) {
  const perMetre = map([1, 0])[0] - map([0, 0])[0];
  const length = roundDown((0.2 * width) / perMetre),
    end = width - 16,
    start = end - length * perMetre;
  context.strokeStyle = colour("--ink");
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(start, height - EDGE - TICK);
  context.lineTo(start, height - EDGE);
  context.lineTo(end, height - EDGE);
  context.lineTo(end, height - EDGE - TICK);
  context.stroke();
  label(context, `${tickText(length)} m`, (start + end) / 2, height - EDGE - 8);
}

function triangle(path, nodes, pixels) {
  const [a, b, c, ab, bc, ca] = nodes.map((node) => pixels[node]);
  path.moveTo(...a);
  for (const corner of [ab, b, bc, c, ca]) path.lineTo(...corner);
  path.closePath();
}

function regions(context, { mesh }, pixels) {
  const colours = regionColours(mesh.region_names.length);
  colours.forEach((paintOf, region) => {
    const path = new Path2D();
    mesh.triangles.forEach((nodes, e) => {
      if (mesh.regions[e] === region) triangle(path, nodes, pixels);
    });
    context.fillStyle = paintOf;
    context.fill(path);
  });
}

function contours(context, { mesh, shown }, pixels) {
  const bands = shown.levels.length - 1;
  const paths = Array.from({ length: bands }, () => new Path2D());
  const bandOf = (value) => {
    let band = 0;
    while (band < bands - 1 && value >= shown.levels[band + 1]) band += 1;
    return band;
  };
  mesh.triangles.forEach((nodes, e) => {
    for (const piece of PIECES) {
      const corners = piece.map((k) => [...pixels[nodes[k]], shown.value(e, k)]);
      const inBands = corners.map(([, , value]) => bandOf(value));
      const first = Math.min(...inBands),
        last = Math.max(...inBands);
      for (let band = first; band <= last; band += 1) {
        const polygon =
          first === last
            ? corners
            : between(
                corners,
                band === 0 ? -Infinity : shown.levels[band],
                band === bands - 1 ? Infinity : shown.levels[band + 1],
              );
        if (polygon.length < 3) continue;
        paths[band].moveTo(polygon[0][0], polygon[0][1]);
        for (const [x, y] of polygon.slice(1)) paths[band].lineTo(x, y);
        paths[band].closePath();
      }
    }
  });
  context.lineWidth = 0.7;
  paths.forEach((path, band) => {
    context.fillStyle = context.strokeStyle = bandColour(band, bands);
    context.fill(path);
    context.stroke(path); // closes the hairlines between neighbours
  });
}

/** Thinner lines where triangles are small on the screen, 0.2 to 1: they shall not hide the colours. */
function fineness(triangles, pixels) {
  const sides = triangles
    .map(([a, b]) => Math.hypot(pixels[a][0] - pixels[b][0], pixels[a][1] - pixels[b][1]))
    .sort((a, b) => a - b);
  return Math.max(0.2, Math.min(1, (sides[sides.length >> 1] ?? 12) / 12));
}

function lines(context, triangles, pixels, paintOf, width) {
  const path = new Path2D();
  for (const nodes of triangles)
    if (thickness(...nodes.slice(0, 3).map((node) => pixels[node])) >= THIN) triangle(path, nodes, pixels);
  context.strokeStyle = paintOf;
  context.lineWidth = width;
  context.stroke(path);
}

function interfaces(context, found, pixels) {
  context.strokeStyle = colour(INTERFACE);
  context.lineWidth = 2;
  context.beginPath();
  for (const nodes of found) {
    for (const [start, end, mid] of [nodes.slice(0, 3), nodes.slice(3)]) {
      context.moveTo(...pixels[start]);
      context.lineTo(...pixels[mid]);
      context.lineTo(...pixels[end]);
    }
  }
  context.stroke();
}

function edges(context, sides, pixels, paintOf, dash) {
  context.strokeStyle = paintOf;
  context.lineWidth = 1;
  context.setLineDash(dash);
  context.beginPath();
  for (const [start, mid, end] of sides) {
    context.moveTo(...pixels[start]);
    context.lineTo(...pixels[mid]);
    context.lineTo(...pixels[end]);
  }
  context.stroke();
  context.setLineDash([]);
}

function label(context, text, x, y, align = "center") {
  context.font = "12px system-ui, sans-serif";
  context.textAlign = align;
  context.lineWidth = 3;
  context.strokeStyle = colour("--paper");
  context.strokeText(text, x, y);
  context.fillStyle = colour("--ink");
  context.fillText(translate(text), x, y);
}

function points(context, mesh, pixels) {
  for (const [name, node] of Object.entries(mesh.points)) {
    const [x, y] = pixels[node];
    context.fillStyle = colour("--ink");
    context.beginPath();
    context.arc(x, y, 3, 0, 2 * Math.PI);
    context.fill();
    label(context, name, x, y + 16);
  }
}

function arrows(context, { vectors, unit }, map, [width, height]) {
  const known = (vector) => vector.map((value) => value ?? 0);
  const length = (vector) => Math.hypot(...known(vector));
  const longest = Math.max(...vectors.flatMap(({ measured, calculated }) => [length(measured), length(calculated)]));
  if (!(longest > 0)) return;
  const factor = (LONGEST_ARROW * width) / longest;
  for (const [which, token, thick] of [
    ["measured", "--ink", 3.5],
    ["calculated", "--series-1", 2],
  ]) {
    for (const vector of vectors) {
      if (vector[which].every((value) => value === null)) continue;
      const [x, y] = map([vector.x, vector.y]);
      const [ux, uy] = known(vector[which]);
      arrow(context, x, y, x + factor * ux, y - factor * uy, colour(token), thick);
    }
  }
  const key = roundDown(longest);
  arrow(context, 16, height - EDGE, 16 + factor * key, height - EDGE, colour("--ink"), 2);
  label(context, `${tickText(key * unit.factor)} ${unit.name}`, 16, height - EDGE - 8, "left");
}

function arrow(context, x0, y0, x1, y1, paintOf, thick) {
  const angle = Math.atan2(y1 - y0, x1 - x0),
    head = Math.min(5 + 2 * thick, Math.hypot(x1 - x0, y1 - y0));
  context.strokeStyle = context.fillStyle = paintOf;
  context.lineWidth = thick;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1 - 0.8 * head * Math.cos(angle), y1 - 0.8 * head * Math.sin(angle));
  context.stroke();
  context.beginPath();
  context.moveTo(x1, y1);
  for (const side of [-0.45, 0.45])
    context.lineTo(x1 - head * Math.cos(angle + side), y1 - head * Math.sin(angle + side));
  context.fill();
}
