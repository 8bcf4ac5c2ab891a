// The list of jobs: kept up to date while somebody looks.
import { renew } from "./renew.js";

const { renew: interval } = document.querySelector("main").dataset;
if (interval) setInterval(() => document.hidden || renew(), Number(interval));
