// A job, live.
import { connection } from "./dom.js";
import { renew } from "./renew.js";
import { follow } from "./stream.js";

const { job, state } = document.querySelector("main").dataset;
follow(job, {
  state,
  onEvent: renew,
  onConnection: (there) => connection(there ? null : "Connection lost; trying again …"),
});
