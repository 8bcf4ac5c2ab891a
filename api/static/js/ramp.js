// Colours of a quantity from low to high: the part of viridis that is visible on white and on black, as in the report.
export const COLOURS = ["#46327e", "#3f4889", "#365d8d", "#2e6f8e", "#277f8e", "#21918c", "#1fa187", "#2db27d", "#46c06f", "#6ccd5a", "#a2da37"];
