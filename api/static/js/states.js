// States of jobs and evaluations: the page brings them, the service defines them (geoswarm/records/states.py).
const told = (name) => new Set(document.body.dataset[name].split(" "));

export const ENDED = told("endedStates"), OPEN = told("openStates"), EVALUATION_STATES = told("evaluationStates");
