// The body of a job: mesh, deformed mesh, vectors measured against calculated, contours of displacement and shear strain.
import { element, failure } from "./dom.js";
import { count, number, withUnit } from "./format.js";
import { get } from "./http.js";
import { BodyCanvas } from "./mesh/canvas.js";
import { controls } from "./mesh/controls.js";
import { INTERFACE, bandColour, regionColours } from "./mesh/drawing.js";
import { box, largestFactor, levels, outline, roundDown } from "./mesh/geometry.js";
import { colour } from "./plot.js";
import { vectorTable } from "./mesh/vectors.js";

const { job, mesh: hasMesh } = document.querySelector("main").dataset;
const place = (id) => document.getElementById(id);
const KEPT = 0.9; // of the factor at which the first triangle would have no area
const view = { mesh: null, fields: null, outline: null, unit: null };
const parts = {};

async function begin(query = {}) {
  try {
    view.mesh = await get(`/jobs/${job}/mesh`, query);
  } catch (error) {
    if (place("content").hidden) place("nothing").replaceChildren(failure(error));
    else tell(error.message);
    return;
  }
  view.query = query;
  view.fields = null;
  view.outline = outline(view.mesh.triangles);
  place("nothing").hidden = true;
  place("content").hidden = false;
  parts.scale ??= place("body").appendChild(element("div", { class: "scale" }));
  parts.node ??= place("body").appendChild(
    element(
      "p",
      { class: "help", role: "status", id: "node" },
      "Point at a node, or go to it with shift and the arrow keys, to read its values.",
    ),
  );
  parts.canvas ??= new BodyCanvas(place("body"), { onNode: pointed });
  parts.controls = controls(place("controls"), view.mesh, { onLook: show, onPeriod: read, onEvaluation: begin });
  const lengths = view.mesh.vectors
    .flatMap(({ measured, calculated }) => [...measured, ...calculated])
    .map((value) => Math.abs(value ?? 0));
  view.unit = unitOf(Math.max(0, ...lengths));
  about();
  show(true);
  place("vectors").replaceChildren(vectorTable(view.mesh.vectors, view.unit));
  if (view.mesh.generation === null) tell("No evaluation has succeeded yet: the mesh is that of the usual geometry.");
  else await read();
}

/** Displacements and strains of the chosen period; the first time the service runs the forward model once more. */
async function read() {
  const { start, end } = parts.controls.period();
  tell("The forward model runs once for the displacements of all nodes …");
  const query = { ...view.query, end, ...(start === null ? { since_beginning: true } : { start }) };
  const { mesh } = view;
  try {
    const fields = await get(`/jobs/${job}/mesh/fields`, query);
    if (mesh !== view.mesh) return;
    view.fields = fields;
    const sizes = fields.displacement.map(([x, y]) => Math.hypot(x, y));
    const largest = Math.max(...sizes);
    view.unit = unitOf(largest);
    view.sizes = sizes;
    const [left, , right] = box(mesh.nodes);
    const limit = KEPT * largestFactor(mesh.nodes, fields.displacement, mesh.triangles);
    parts.controls.ready(roundDown(Math.min(Math.max(1, (0.03 * (right - left)) / (largest || 1e-12)), limit)), limit);
    place("vectors").replaceChildren(vectorTable(mesh.vectors, view.unit));
    tell(
      `Largest displacement ${number(largest * view.unit.factor, 3)} ${view.unit.name}, largest shear strain ${number(100 * Math.max(...fields.shear_strain.flat()), 3)} %.`,
    );
    show();
  } catch (error) {
    tell(error.message);
  }
}

function show(anew = false) {
  const { mesh, fields } = view;
  const { quantity, factor, ...options } = parts.controls.look();
  const places =
    fields && factor > 0
      ? mesh.nodes.map(([x, y], i) => [x + factor * fields.displacement[i][0], y + factor * fields.displacement[i][1]])
      : mesh.nodes;
  const shown = fields && quantity !== "regions" ? contour(quantity) : "regions";
  const label = `${shown === "regions" ? "Mesh with its regions" : `Contours of ${shown.name}`}, ${count(mesh.triangles.length)} triangles${fields && factor > 0 ? `, deformed ${factor} times` : ""}`;
  parts.canvas.show(
    { mesh, places, outline: view.outline, shown, options, vectors: mesh.vectors, unit: view.unit, label },
    anew === true,
  );
  legend(shown);
}

function contour(quantity) {
  const { mesh, fields, unit, sizes } = view;
  const nodal = { size: (n) => sizes[n], ux: (n) => fields.displacement[n][0], uy: (n) => fields.displacement[n][1] }[
    quantity
  ];
  const names = {
    size: "displacement",
    ux: "horizontal displacement",
    uy: "vertical displacement",
    shear: "shear strain",
  };
  const factor = nodal ? unit.factor : 100;
  const value = nodal ? (e, k) => factor * nodal(mesh.triangles[e][k]) : (e, k) => factor * fields.shear_strain[e][k];
  let low = Infinity,
    high = -Infinity;
  mesh.triangles.forEach((_, e) => {
    for (let k = 0; k < 6; k += 1) {
      const here = value(e, k);
      if (here < low) low = here;
      if (here > high) high = here;
    }
  });
  return { levels: levels(low, high), value, name: names[quantity], unit: nodal ? unit.name : "%" };
}

function legend(shown) {
  const swatch = (paint) => {
    const canvas = element("canvas", { width: 1, height: 1, "aria-hidden": true });
    const context = canvas.getContext("2d");
    context.fillStyle = paint;
    context.fillRect(0, 0, 1, 1);
    return canvas;
  };
  const { mesh } = view;
  if (shown === "regions") {
    const colours = regionColours(mesh.region_names.length);
    parts.scale.replaceChildren(
      ...mesh.region_names.map((name, i) => element("span", { class: "region" }, swatch(colours[i]), name)),
    );
  } else {
    const bands = shown.levels.length - 1;
    parts.scale.replaceChildren(
      element("span", {}, `${shown.name} [${shown.unit}]`),
      element(
        "span",
        { class: "steps" },
        Array.from({ length: bands }, (_, band) =>
          element("span", { class: "step" }, swatch(bandColour(band, bands)), `${number(shown.levels[band], 3)}`),
        ),
        element(
          "span",
          { class: "step" },
          element("canvas", { width: 1, height: 1, "aria-hidden": true }),
          number(shown.levels[bands], 3),
        ),
      ),
    );
  }
  if (mesh.interfaces.length)
    parts.scale.append(element("span", { class: "region" }, swatch(colour(INTERFACE)), "interface"));
  if (parts.controls.look().vectors && mesh.vectors.length)
    parts.scale.append(
      element("span", { class: "region" }, swatch(getComputedStyle(document.body).color), "measured"),
      element("span", { class: "region" }, swatch(regionColours(1)[0].replace("0.45", "1")), "calculated"),
    );
}

function pointed(node) {
  if (node === null) return;
  const [x, y] = view.mesh.nodes[node];
  const name = Object.keys(view.mesh.points).find((one) => view.mesh.points[one] === node);
  const told = [`${name ? `Point ${name}, node` : "Node"} ${node}: ${placeOf([x, y])}`];
  if (view.fields) {
    const { factor, name: unit } = view.unit;
    const [ux, uy] = view.fields.displacement[node];
    told.push(`ux = ${number(ux * factor, 3)} ${unit}, uy = ${number(uy * factor, 3)} ${unit}`);
    const e = view.mesh.triangles.findIndex((nodes) => nodes.includes(node));
    if (e >= 0)
      told.push(`shear strain ${number(100 * view.fields.shear_strain[e][view.mesh.triangles[e].indexOf(node)], 3)} %`);
  }
  parts.node.textContent = told.join("; ");
}

const placeOf = ([x, y]) => `x = ${number(x, 5)} m, y = ${number(y, 5)} m`;

function about() {
  const { mesh } = view;
  const [left, bottom, right, top] = box(mesh.nodes);
  const rows = [
    ["Triangles of six nodes", count(mesh.triangles.length)],
    ["Nodes", count(mesh.nodes.length)],
    ["Interfaces", count(mesh.interfaces.length)],
    ["Size", `${number(right - left, 4)} m × ${number(top - bottom, 4)} m`],
    ["Evaluation", mesh.generation === null ? "none yet" : `generation ${mesh.generation}, particle ${mesh.particle}`],
    [withUnit("Objective", mesh.objective_unit), number(mesh.objective)],
    ...mesh.region_names.map((name, i) => [
      `Triangles of ${name}`,
      count(mesh.regions.filter((region) => region === i).length),
    ]),
    ...Object.entries(mesh.points).map(([name, node]) => [`Point ${name}`, placeOf(mesh.nodes[node])]),
  ];
  place("about").replaceChildren(
    ...rows.map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))),
  );
}

/** Metres, or millimetres where these are easier to read. */
function unitOf(largest) {
  return largest < 0.1 ? { name: "mm", factor: 1000 } : { name: "m", factor: 1 };
}

function tell(text) {
  place("told").textContent = text;
}

if (hasMesh === "true") await begin();
