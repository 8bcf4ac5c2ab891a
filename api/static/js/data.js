// The problem of a job to take elsewhere, its readings as they were read, and everything as files.
import { figures } from "./job/figures.js";
import { problemText } from "./job/copy.js";
import { readingTables } from "./job/reading_tables.js";
import { reports } from "./job/reports.js";

const { job, fitted } = document.querySelector("main").dataset;
reports();
problemText(job, document.getElementById("problem"));
readingTables(job, document.getElementById("readings"));
if (fitted === "true") figures(job, document.getElementById("figures"));
