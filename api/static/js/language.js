// The pages in other languages: what stands on a page in English is replaced as it appears, by a catalogue of phrases.
//
// A catalogue is a file `languages/CODE.json`: {name, decimal, phrases: {English: phrase}}. `{}` stands for what is
// inserted, in the same order in both; `{2} … {1}` says another order. What stands under translate="no", in code and
// in fields stays as it is. theme.js has chosen the language, and asked for the file, before the first paint.

const LETTERS = /\p{L}{2}/u;
const NUMBER = /(?<![\p{L}\d_.])\d[\d\u202f]*(?:\.\d+)?(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?/gu;
const DECIMAL = /(?<![\p{L}\d_.])(\d[\d\u202f]*)\.(\d+)(?![\p{L}\d_]|\.\d)/gu;
const UNITS = /^(?:[munµ]?m[²³]?|[kMG]?Pa|kN(?:\/m[²³]?)?|min|ms|h|d|s|day|base|deg|°|[\d\s./·⁻⁰¹²³⁴⁵⁶⁷⁸⁹^*-])+$/;
const SHORTENED =
  "Mech|Eng|Geotech|Geotechn|Found|Int|Num|J|Proc|Conf|Soils|ed|No|Fig|Eq|e\\.g|i\\.e|cf|Mater|Frict|Numer|Anal";
const SENTENCES = new RegExp(`(?<=(?<!\\b(?:${SHORTENED}))[.!?…]) (?=\\S)`);
const CLAUSES = /(?<=[:;]) (?=\S)/;
const CUTS = [
  [" · ", " · "],
  [SENTENCES, " "],
  [CLAUSES, " "],
];
const EDGES = /^([\s,;:·()[\]“”"–—…⚠×→←▲▼+=<≤≥-]*)(.*?)([\s,;:·()[\]“”"–—…×→←▲▼.?]*)$/su;
const MARKED = /^(.+)([:;,])$/su;
const ATTRIBUTES = ["title", "aria-label", "placeholder", "alt", "label", "aria-valuetext", "data-label"];
const KEPT = "script,style,code,pre,[translate=no]";
const SHORT = 12; // letters of a pattern that is asked only after a text has been cut into its sentences
const LONG = 30; // letters of a pattern that may be a sentence of several clauses, with or without its dot
const FEW = 8; // letters of a pattern, such as "{} of {}", that joins names, not sentences

/** What translates texts by a catalogue: `translate(text)`; `missing` collects what it has no phrase for. */
export class Translator {
  constructor({ decimal = ".", phrases = {} }) {
    this.decimal = decimal;
    this.missing = new Set();
    this.exact = new Map();
    this.patterns = [];
    this.known = new Map();
    this.routes = new Map();
    for (const [english, phrase] of Object.entries(phrases)) {
      if (!english.includes("{}")) this.exact.set(english, phrase);
      else if (LETTERS.test(english)) this.patterns.push(pattern(english, phrase));
    }
    this.patterns.sort((one, other) => other.size - one.size);
  }

  /** A text of the page in the language; with its decimals, also where there is no phrase for it. */
  translate(text) {
    let found = this.known.get(text);
    if (found === undefined) {
      if (this.known.size > 20_000) this.known.clear();
      found = this.numbers(this.whole(text));
      this.known.set(text, found);
      this.known.set(found, found); // a plot shows again what was translated for it
    }
    return found;
  }

  /** Numbers as the language writes them. */
  numbers(text) {
    return this.decimal === "." ? text : text.replace(DECIMAL, `$1${this.decimal}$2`);
  }

  whole(text, collect = true) {
    if (!LETTERS.test(text) || UNITS.test(text)) return text;
    const [, before, inner, after] = /^(\s*)(.*?)(\s*)$/su.exec(text);
    const plain = inner.replace(/[^\S\u202f]+/g, " ");
    const found = this.phrase(plain);
    if (found !== undefined) return before + (inner.includes("\u00a0") ? unbroken(found) : found) + after;
    if (collect) this.missing.add(plain); // what a pattern takes is a name or a value, in most cases
    return text;
  }

  /** The phrase for a text, or for its parts; undefined where no part has one. */
  phrase(text) {
    const whole = this.own(text) ?? this.matched(text, SHORT, Infinity) ?? this.dotted(text);
    if (whole !== undefined) return whole;
    for (const [cut, joined] of CUTS) {
      const parts = text.split(cut);
      if (parts.length > 1) return parts.map((part) => this.whole(part)).join(joined);
    }
    const marked = MARKED.exec(text);
    const plain = marked && (this.exact.get(marked[1]) ?? this.matched(marked[1], FEW, Infinity));
    if (plain !== undefined && plain !== null) return plain + marked[2];
    const [, before, inner, after] = EDGES.exec(text);
    const edged = inner && inner !== text;
    if (edged && (!LETTERS.test(inner) || UNITS.test(inner))) return text;
    const found = edged ? (this.exact.get(inner) ?? this.matched(inner, SHORT, Infinity)) : undefined;
    if (found !== undefined) return before + found + after;
    const short = this.matched(text, 0, SHORT);
    if (short !== undefined || !edged) return short;
    const within = this.matched(inner, 0, SHORT);
    return within === undefined ? undefined : before + within + after;
  }

  /** By a pattern of many letters without the dot that the text ends with. */
  dotted(text) {
    const found = text.endsWith(".") ? this.matched(text.slice(0, -1), LONG, Infinity) : undefined;
    return found && `${found}.`;
  }

  /** The phrase for a text, or for the one that the form made a sentence of: it begins with a capital and ends with a dot. */
  own(text) {
    const found = this.exact.get(text);
    if (found !== undefined || !text.endsWith(".")) return found;
    const inner = text.slice(0, -1);
    const same = this.exact.get(inner);
    if (same) return `${same}.`;
    const plain = this.exact.get(inner[0].toLowerCase() + inner.slice(1));
    return plain && `${plain[0].toUpperCase()}${plain.slice(1)}.`;
  }

  /** By a pattern of `least` to `most` letters; texts that differ in numbers alone go by the same one. */
  matched(text, least, most) {
    const kind = `${least} ${text.replace(NUMBER, "#")}`;
    if (!this.routes.has(kind)) {
      this.routes.set(
        kind,
        this.patterns.find((one) => fits(one, text, least, most)),
      );
    }
    const route = this.routes.get(kind);
    if (!route?.expression.test(text)) return undefined;
    const items = text.split(", ");
    const list = items.every((item) => route.expression.test(item)); // each item goes by the pattern
    return (list ? items : [text]).map((item) => this.made(route, item)).join(", ");
  }

  made({ expression, make }, text) {
    const inserted = expression.exec(text).slice(1);
    return make(inserted.map((part) => (part ? this.whole(part, false) : "")));
  }
}

/** 95 % in one line, as in the English text. */
const unbroken = (text) => text.replace(/(?<=\d) %/g, "\u00a0%");

const fits = ({ size, longest, expression }, text, least, most) =>
  size >= least && size < most && text.includes(longest) && expression.test(text);

function pattern(english, phrase) {
  const pieces = english.split("{}");
  const escaped = pieces.map((piece) => piece.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  const size = pieces.join("").length;
  const taken = size < FEW ? "((?:\\S+ ){0,3}\\S*)" : "(.*?)";
  const parts = phrase.split(/(\{\d*\})/);
  return {
    size,
    longest: pieces.reduce((best, piece) => (piece.length > best.length ? piece : best), ""),
    expression: new RegExp(`^${escaped.join(taken)}$`, "su"),
    make(inserted) {
      let next = 0;
      return parts.map((part, i) => (i % 2 ? inserted[Number(part.slice(1, -1) || ++next) - 1] : part)).join("");
    },
  };
}

const root = globalThis.document?.documentElement;
const translator = root && root.lang !== "en" ? await loaded() : null;

async function loaded() {
  try {
    return new Translator(await (await window.catalogue).json());
  } catch {
    root.lang = "en"; // the page is better in English than not at all
    delete root.dataset.waits;
    return null;
  }
}

/** A text that is not put on the page as text: on a canvas, in a plot, in a notification. */
export const translate = (text) => (translator && typeof text === "string" ? translator.translate(text) : text);

/** What stands for decimal point and thousands, as Plotly takes it. */
export const separators = `${translator?.decimal ?? "."}\u202f`;

/** For dates: the reader's own way of writing them where that is in the page's language. */
export const locale = () => (navigator.language.startsWith(root.lang) ? undefined : root.lang);

/** Texts of this page without a phrase. */
export const untranslated = () => [...(translator?.missing ?? [])];

const made = new WeakMap(); // node: what was put there, which is not translated again

function put(node, name, text, set) {
  const last = made.get(node)?.[name];
  if (text === last || !text) return;
  const now = translator.translate(text);
  made.set(node, { ...made.get(node), [name]: now });
  if (now !== text) set(now);
}

function putAttributes(element) {
  for (const name of ATTRIBUTES)
    put(element, name, element.getAttribute(name), (text) => {
      element.setAttribute(name, text);
    });
}

/** Translate what stands below a node now, not only once the browser says that it has changed. */
export function translateBelow(node) {
  if (!translator) return;
  if (node.nodeType === Node.TEXT_NODE) {
    if (node.parentElement && !node.parentElement.closest(`textarea,${KEPT}`))
      put(node, "", node.data, (text) => {
        node.data = text;
      });
  } else if (node.nodeType === Node.ELEMENT_NODE && !node.closest(KEPT)) {
    putAttributes(node);
    for (const child of node.childNodes) translateBelow(child);
  }
}

if (translator) {
  translateBelow(root);
  delete root.dataset.waits;
  new MutationObserver((changes) => {
    for (const { type, target, addedNodes } of changes) {
      if (type === "childList") addedNodes.forEach(translateBelow);
      else if (type === "characterData") translateBelow(target);
      else if (!target.closest(KEPT)) putAttributes(target);
    }
  }).observe(root, {
    subtree: true,
    childList: true,
    characterData: true,
    attributes: true,
    attributeFilter: ATTRIBUTES,
  });
}
