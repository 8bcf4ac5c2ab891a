// States of jobs and evaluations: the page brings them, the service defines them (geoswarm/records/states.py).
const statesIn = (name) => new Set(document.body.dataset[name].split(" "));

export const ENDED = statesIn("endedStates"),
  OPEN = statesIn("openStates"),
  EVALUATION_STATES = statesIn("evaluationStates");
