// Files of a plot of evaluations: SVG and PNG as on the page, CSV with the numbers of all evaluations.
import { withUnit } from "../format.js";
import { colour, csvOf, fileButtons, handOver } from "../plot.js";
import { svg } from "../dom.js";

const STYLES = [
  "fill",
  "fill-opacity",
  "stroke",
  "stroke-width",
  "stroke-dasharray",
  "opacity",
  "font-family",
  "font-size",
  "font-weight",
  "text-anchor",
];
const DIGITS = 7; // of the numbers that the service sends

/** Buttons for a `plot` with the canvases `back` and `front` below the SVG `marks`, its `cloud` and the unit of f. */
export const saveButtons = (plot, filename) =>
  fileButtons(async (form) => {
    if (form === "csv") return handOver(new Blob([csvOf(columns(plot))], { type: "text/csv" }), `${filename}.csv`);
    const drawing = drawn(plot);
    const text = new XMLSerializer().serializeToString(drawing);
    if (form === "svg") return handOver(new Blob([text], { type: "image/svg+xml" }), `${filename}.svg`);
    return handOver(await raster(text, plot.back), `${filename}.png`);
  });

/** The evaluations, best first: objective, parameters, and whether each is a good fit inside all ranges. */
function columns({ cloud, threshold, objectiveUnit }) {
  const sent = (values) => Array.from(cloud.order, (n) => Number(values[n].toPrecision(DIGITS)));
  const chosen = new Set(cloud.chosen(threshold));
  return {
    [withUnit("f", objectiveUnit)]: sent(cloud.objective),
    ...Object.fromEntries(
      cloud.parameters.map(({ name, unit }, index) => [withUnit(name, unit), sent(cloud.values(index))]),
    ),
    chosen: Array.from(cloud.order, (n) => (chosen.has(n) ? 1 : 0)),
  };
}

/** One SVG of all layers, with the colours that the page gives them: the points and lines are a picture inside it. */
function drawn({ back, front, marks }) {
  const copy = marks.cloneNode(true);
  const shown = [marks, ...marks.querySelectorAll("*")];
  [copy, ...copy.querySelectorAll("*")].forEach((node, index) => {
    const style = getComputedStyle(shown[index]);
    node.removeAttribute("style");
    node.removeAttribute("class");
    for (const name of STYLES) node.setAttribute(name, style.getPropertyValue(name));
  });
  const size = { width: marks.getAttribute("width"), height: marks.getAttribute("height") };
  copy.prepend(
    svg("rect", { ...size, fill: colour("--paper") }),
    ...[back, front].map((canvas) => svg("image", { ...size, href: canvas.toDataURL() })),
  );
  return copy;
}

/** The same as a PNG, with as many pixels as the canvas has. */
async function raster(text, { width, height }) {
  const picture = new Image();
  picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await picture.decode();
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width, height });
  canvas.getContext("2d").drawImage(picture, 0, 0, width, height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
