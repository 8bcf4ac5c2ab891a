// Each parameter free, fixed or linked, and the constraints between them.
import { element, empty, exchange, svg } from "../dom.js";
import { number, symbol } from "../format.js";
import { pathText } from "./draft.js";
import { expectedPlace, indexProperties, showExpected } from "./expected.js";
import { checkbox, errorPlace, field, idOf } from "./fields.js";
import { button, sentence } from "./schema_form.js";

const MODES = { free: "free", fixed: "fixed", linked: "linked" };

/** What a section of a parameter is; null when it is not given. */
function modeOf(section) {
  if (!section || typeof section !== "object") return null;
  if ("expression" in section) return "linked";
  return "value" in section ? "fixed" : "free";
}

/** Bounds to begin with: the usual range, on a log scale when it spans a decade. */
function started(mode, info, old) {
  if (mode === "fixed") return { value: old?.initial ?? info?.default ?? null };
  if (mode === "linked") return { expression: "" };
  const [low, high] = info?.typical ?? [];
  const lower = low === 0 && info.lower_open ? high / 1000 : low; // 0 itself may be refused
  return { lower: lower ?? null, upper: high ?? null, ...(lower > 0 && high / lower >= 10 ? { scale: "log" } : {}) };
}

export function parametersSection(context, place) {
  const { draft } = context;
  const list = element("div", {}),
    rules = element("div", {});
  let drawnFor = "";
  const given = () => {
    const all = draft.read(["parameters"]);
    return all && typeof all === "object" ? all : {};
  };
  const infos = () => draft.model().parameters;

  function card(name, info) {
    const path = ["parameters", name];
    const mode = modeOf(draft.read(path));
    const id = `${idOf(path)}-mode`;
    const offered = [
      mode === null ? ["", info?.default === null || !info ? "choose …" : `default: ${number(info.default)}`] : null,
      ...Object.entries(MODES),
    ].filter(Boolean);
    const all =
      mode !== null && info && info.default !== null ? [["", `default: ${number(info.default)}`], ...offered] : offered;
    const pick = element(
      "select",
      { id, dataset: { path: pathText(path) } },
      all.map(([value, label]) => element("option", { value, selected: value === (mode ?? "") }, label)),
    );
    pick.addEventListener("change", () => {
      draft.write(path, pick.value ? started(pick.value, info, draft.read(path)) : undefined);
      draw();
    });
    const unit = info?.unit;
    const range = info?.typical
      ? [
          ` Usual: ${number(info.typical[0])} to ${number(info.typical[1])}${unit ? ` ${unit}` : ""}`,
          info.source ? element("span", { translate: "no" }, `, ${info.source}`) : "",
          ".",
        ]
      : [];
    return element(
      "div",
      { class: `item parameter ${mode ?? "absent"}` },
      element(
        "div",
        { class: "parameter-name" },
        element(
          "h3",
          {},
          symbol(name),
          unit ? element("small", {}, ` [${unit}]`) : null,
          symbol(name) === name ? null : element("small", {}, ` ${name}`),
        ),
        element(
          "p",
          { class: "help" },
          sentence(info?.description) ?? (info ? "" : "A parameter of your own, for linked ones."),
          range,
        ),
        expectedPlace(name),
      ),
      element(
        "div",
        { class: "field" },
        element("label", { for: id }, "Mode", element("span", { class: "visually-hidden" }, ` of ${name}`)),
        pick,
      ),
      inputs(path, name, mode, unit),
      mode === "free" && info?.typical ? rangeBar(path, info) : null,
      info
        ? null
        : button(`Remove ${name}`, () => {
            draft.write(path, undefined);
            draw();
          }),
      errorPlace(path),
    );
  }

  function inputs(path, name, mode, unit) {
    const one = (key, label, more = {}) =>
      field(draft, [...path, key], {
        label: element("span", {}, label, element("span", { class: "visually-hidden" }, ` of ${name}`)),
        kind: "number",
        unit,
        ...more,
      });
    if (mode === "free") {
      return [
        one("lower", "Lower bound", { required: true, blank: null }),
        one("upper", "Upper bound", { required: true, blank: null }),
        one("initial", "Estimate"),
        logScale(path, name),
        draft.read([...path, "integer"])
          ? checkbox(draft, [...path, "integer"], { label: "Whole numbers only" })
          : null,
      ];
    }
    if (mode === "fixed") return one("value", "Value", { required: true, blank: null });
    if (mode === "linked")
      return one("expression", "Expression", {
        kind: "text",
        unit: null,
        required: true,
        blank: "",
        wide: true,
        help: "Of other parameters, such as 0.5 * lambda_star.",
      });
    return null;
  }

  /** Bounds as a bar over the usual range; amber where they leave it. */
  function rangeBar(path, { typical: [low, high], unit }) {
    const place = element("p", { class: "bounds", dataset: { bounds: path.at(-1) } });
    const show = () => {
      const { lower, upper, scale } = draft.read(path) ?? {};
      const known = typeof lower === "number" && typeof upper === "number" && upper > lower;
      place.hidden = !known;
      if (!known) return;
      const log = scale === "log" && lower > 0 && low > 0;
      const at = (value) => (log ? Math.log(value) : value);
      const [from, to] = [Math.min(at(lower), at(low)), Math.max(at(upper), at(high))];
      const share = (value) => `${((100 * (at(value) - from)) / (to - from || 1)).toFixed(2)}%`;
      const out = lower < low * (1 - 1e-9) || upper > high * (1 + 1e-9);
      const bar = (kind, a, b) =>
        svg("rect", {
          class: kind,
          x: share(a),
          y: kind === "usual" ? 2 : 5,
          width: `${(parseFloat(share(b)) - parseFloat(share(a))).toFixed(2)}%`,
          height: kind === "usual" ? 12 : 6,
        });
      const words = out
        ? `Searched beyond the usual range, ${number(low)} to ${number(high)}${unit ? ` ${unit}` : ""}`
        : "Searched within the usual range";
      exchange(
        place,
        svg(
          "svg",
          { class: out ? "bar out" : "bar", role: "img", "aria-label": words },
          bar("usual", low, high),
          bar("searched", lower, upper),
        ),
        element("small", {}, words),
      );
    };
    show();
    draft.on("change", () => {
      if (place.isConnected) show();
    });
    return place;
  }

  function logScale(path, name) {
    const id = idOf([...path, "scale"]);
    const box = element("input", {
      type: "checkbox",
      id,
      checked: draft.read([...path, "scale"]) === "log",
      dataset: { path: pathText([...path, "scale"]) },
    });
    box.addEventListener("change", () => draft.write([...path, "scale"], box.checked ? "log" : undefined));
    return element(
      "div",
      { class: "field check" },
      element("label", { for: id }, box, " Log scale", element("span", { class: "visually-hidden" }, ` of ${name}`)),
      errorPlace([...path, "scale"]),
    );
  }

  function draw() {
    drawnFor = key();
    const known = infos();
    const names = new Set(known.map((info) => info.name));
    // A combined model also knows each parameter for one part alone: these are wanted seldom.
    const partial = (name) => name.includes(".") && names.has(name.slice(name.lastIndexOf(".") + 1));
    const shared = (info) =>
      !partial(info.name) && !known.some((one) => one.name.endsWith(`.${info.name}`) && one.name in given());
    const first = known.filter((info) => info.name in given() || (info.default === null && shared(info)));
    const rest = known.filter((info) => !first.includes(info));
    const own = Object.keys(given()).filter((name) => !names.has(name));
    const free = Object.values(given()).filter((one) => modeOf(one) === "free").length;
    // Who takes one after the other finds the rest still unfolded.
    const open = list.querySelector(":scope > details.more")?.open ?? false;
    exchange(
      list,
      known.length || own.length
        ? element(
            "p",
            { class: "help" },
            `${free} free. Free ones are identified between their bounds, fixed ones are known, linked ones follow from others.`,
          )
        : empty("Describe the forward model first; its parameters then appear here."),
      first.map((info) => card(info.name, info)),
      own.map((name) => card(name, null)),
      rest.length
        ? element(
            "details",
            { class: "more", open },
            element(
              "summary",
              {},
              `Further parameters: ${rest
                .slice(0, 6)
                .map((info) => symbol(info.name))
                .join(", ")}${rest.length > 6 ? " …" : ""}`,
            ),
            rest.map((info) => card(info.name, info)),
          )
        : null,
      known.length ? helper() : null,
      errorPlace(["parameters"]),
    );
    showExpected(list, draft.answer?.estimates ?? []);
    drawRules();
  }

  function helper() {
    const input = element("input", { type: "text", id: "helper-name", spellcheck: "false", autocomplete: "off" });
    const add = () => {
      const name = input.value.trim();
      if (!name || name in given()) return input.focus();
      draft.write(["parameters", name], { lower: 0, upper: 1 });
      draw();
    };
    return element(
      "details",
      { class: "more" },
      element("summary", {}, "Another parameter"),
      element(
        "p",
        { class: "help" },
        "One that linked parameters use, or the value for one part of a combined model alone (",
        element("code", {}, "part.name"),
        ").",
      ),
      element("div", { class: "buttons" }, element("label", { for: "helper-name" }, "Name"), input, button("Add", add)),
    );
  }

  function drawRules() {
    const all = draft.read(["constraints"]);
    const texts = Array.isArray(all) ? all : [];
    const indices = ["lambda_star", "kappa_star"].every((name) => modeOf(given()[name]) === "free");
    const usual =
      indices && !texts.some((text) => /lambda_star|kappa_star/.test(text)) ? "lambda_star > kappa_star" : null;
    const add = (text) => {
      draft.write(["constraints", texts.length], text);
      drawRules();
      document.getElementById(idOf(["constraints", texts.length]))?.focus();
    };
    exchange(
      rules,
      element("p", { class: "help" }, "Comparisons that hold for every proposal of the search, checked as you type."),
      texts.map((_, i) =>
        element(
          "div",
          { class: "constraint" },
          field(draft, ["constraints", i], { label: `Constraint ${i + 1}`, wide: true }),
          button(
            "Remove",
            () => {
              draft.write(["constraints", i], undefined);
              drawRules();
            },
            { "aria-label": `Remove constraint ${i + 1}` },
          ),
        ),
      ),
      element(
        "div",
        { class: "buttons" },
        button("Add a constraint", () => add("")),
        usual ? button(`Add ${usual}`, () => add(usual)) : null,
      ),
      errorPlace(["constraints"]),
    );
  }

  const key = () => JSON.stringify([infos(), Object.entries(given()).map(([name, one]) => [name, modeOf(one)])]);
  place.replaceChildren(indexProperties(context), list, element("h3", {}, "Constraints"), rules);
  draft.on("replace", draw);
  draft.on("answer", ({ estimates }) => {
    if (key() !== drawnFor) draw();
    else showExpected(list, estimates ?? []);
  });
  draw();
}
