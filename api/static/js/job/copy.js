// A job to take elsewhere: its problem as YAML, Python, commands of a shell, or a request; its values as a material set.
import { announce, dialog, element, once } from "../dom.js";
import { get, post } from "../http.js";

const KEY = "# where the service asks for a key: export GEOSWARM_API_KEY=...\n";

const FORMS = {
  YAML: async (id) => {
    const { yaml } = await post("/problems/read", await get(`/jobs/${id}/problem`));
    if (yaml === null)
      throw new Error(
        "This problem is too long to be shown as text; take “Problem (JSON)”, which a problem file may be, too.",
      );
    return yaml;
  },
  Python: async (id) => `import geoswarm as gs

# where the service asks for a key: gs.Client(address, api_key="...")
with gs.Client("${location.origin}") as client:
    problem = client.problem("${id}")
    job = client.wait(client.submit(problem).id)
    print(job.parameters)
`,
  "Command line": async (id) => `${KEY}curl -sS ${header()}${location.origin}/api/v1/jobs/${id}/problem -o problem.json
geoswarm run problem.json --output results
geoswarm submit problem.json --url ${location.origin} --watch
`,
  curl: async (id) => `${KEY}curl -sS ${header()}${location.origin}/api/v1/jobs/${id}/problem |
  curl -sS ${header()}-H "Content-Type: application/json" --data-binary @- ${location.origin}/api/v1/jobs
`,
};

/** Only a service with keys has a way to sign out. */
const header = () => (document.getElementById("sign-out") ? '-H "X-API-Key: $GEOSWARM_API_KEY" ' : "");

/** A row of buttons, one a form: {name: a function that makes the text}. */
function copyButtons(words, forms) {
  return element(
    "p",
    { class: "buttons" },
    element("span", { class: "help" }, words),
    Object.entries(forms).map(([name, make]) => {
      const button = element(
        "button",
        { type: "button", class: "quiet small", onclick: () => once(button, () => copied(name, make)) },
        name,
      );
      return button;
    }),
  );
}

const MOST = 100_000; // characters

/** The problem of a job as text, and to copy. */
export async function problemText(id, place) {
  const text = element("pre", { tabindex: "0", "aria-label": "Problem as YAML" }, "Loading …");
  place.replaceChildren(
    copyButtons("Copy as", Object.fromEntries(Object.entries(FORMS).map(([name, make]) => [name, () => make(id)]))),
    text,
  );
  try {
    const yaml = await FORMS.YAML(id);
    text.textContent = yaml.length > MOST ? `${yaml.slice(0, MOST)}\n…` : yaml;
  } catch (error) {
    text.textContent = error.message;
  }
}

const PLAXIS = {
  lambda_star: "λ* (lambda*)",
  kappa_star: "κ* (kappa*)",
  mu_star: "μ* (mu*)",
  c: "c'ref",
  phi: "φ' (phi)",
  psi: "ψ (psi)",
  nu_ur: "ν'ur",
  nu: "ν' (nu)",
  E: "E'",
  e0: "e_init",
};
const quoted = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** The values found as a material set: rows of {name, unit, value, lower, upper}, as `found()` gives them; null ends are not known. */
export function materialButtons(found) {
  const table = (rows, separator, cell) => rows.map((row) => row.map(cell).join(separator)).join("\n") + "\n";
  const end = (value) => (value === null ? "" : String(value));
  return copyButtons("Copy the values as", {
    "YAML values": () =>
      found()
        .map(({ name, unit, value }) => `${name}: ${value}${unit ? `  # ${unit}` : ""}\n`)
        .join(""),
    "CSV values": () =>
      table(
        [
          ["parameter", "unit", "value", "interval_lower", "interval_upper"],
          ...found().map(({ name, unit, value, lower, upper }) => [name, unit, String(value), end(lower), end(upper)]),
        ],
        ",",
        quoted,
      ),
    "PLAXIS table": () =>
      table(
        [
          ["Parameter", "Value", "Unit"],
          ...found().map(({ name, unit, value }) => [
            PLAXIS[name.slice(name.lastIndexOf(".") + 1)] ?? name,
            String(Number(value.toPrecision(6))),
            unit === "kPa" ? "kN/m²" : unit || "-",
          ]),
        ],
        "\t",
        (text) => text,
      ),
  });
}

async function copied(name, make) {
  let text;
  try {
    text = await make();
  } catch (error) {
    return announce(error.message, 12);
  }
  try {
    await navigator.clipboard.writeText(text);
    announce(`Copied as ${name}.`);
  } catch {
    // plain HTTP from another host, or not allowed
    dialog(`To copy: ${name}`, element("pre", { tabindex: "0", class: "copied" }, text));
  }
}
