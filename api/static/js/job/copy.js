// The problem of a job to take elsewhere: as YAML, Python, commands of a shell, or a request.
import { announce, dialog, element, once } from "../dom.js";
import { get, post } from "../http.js";

const KEY = "# where the service asks for a key: export GEOSWARM_API_KEY=...\n";

const FORMS = {
  YAML: async (id) => {
    const { yaml } = await post("/problems/read", await get(`/jobs/${id}/problem`));
    if (yaml === null) throw new Error("This problem is too long to be shown as text; take “Problem (JSON)”, which a problem file may be, too.");
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

/** A row of buttons, one a form. */
export function copyButtons(id) {
  return element("p", { class: "buttons" }, element("span", { class: "help" }, "Copy as"), Object.entries(FORMS).map(([name, make]) => {
    const button = element("button", { type: "button", class: "quiet small", onclick: () => once(button, () => copied(name, () => make(id))) }, name);
    return button;
  }));
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
  } catch { // plain HTTP from another host, or not allowed
    dialog(`The problem as ${name}`, element("pre", { tabindex: "0", class: "copied" }, text));
  }
}
