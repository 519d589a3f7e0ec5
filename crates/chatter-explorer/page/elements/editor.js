/** The model's text, with its errors underlined as it is typed. */

import { make, save } from "./dom.js";
import { DOCUMENT, document_of } from "../asking/records.js";
import { Latest, Refused, is_abort } from "../asking/transport.js";

/**
 * @typedef {{ message: string, label: string | null, help: string | null, line: number, column: number, from: number | null,
 *   to: number | null, source: string, rendered: string }} Problem
 */

/** After the latest letter, so long until the text is checked, in milliseconds. */
const PAUSE = 120;

export class Editor {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     */
    constructor(ask, store) {
        this.ask = ask;
        this.store = store;
        this.latest = new Latest(2000);
        this.timer = 0;
        /** @type {((good: boolean) => void) | null} */
        this.given_up = null;
        /** @type {Problem[]} */
        this.problems = [];
        this.backdrop = make("pre", { class: "backdrop", "aria-hidden": "true" });
        this.gutter = make("pre", { class: "gutter", "aria-hidden": "true" });
        this.area = make("textarea", {
            spellcheck: "false", autocomplete: "off", autocapitalize: "off", wrap: "off", "aria-label": "Model file", "aria-describedby": "problems",
            oninput: () => this.typed(),
            onscroll: () => this.scroll(),
        });
        this.list = make("ol", { id: "problems", class: "problems", "aria-live": "polite" });
        const button = make("button", { type: "button", onclick: () => save(`${store.state.name.replace(/^.*[/\\]/, "").replace(/\.toml$/, "")}.toml`, store.state.text) }, "Save as file");
        this.element = make(
            "div", { class: "editor" },
            make("div", { class: "sheet" }, this.gutter, make("div", { class: "text" }, this.backdrop, this.area)),
            this.list,
            make("div", { class: "row" }, button),
        );
    }

    /** @param {string} text */
    show(text) {
        if (this.area.value !== text) this.area.value = text;
        this.mark();
    }

    typed() {
        const { value } = this.area;
        this.store.state.text = value;
        this.mark();
        window.clearTimeout(this.timer);
        this.timer = window.setTimeout(() => void this.check(), PAUSE);
    }

    /**
     * Has the model checked; the others hear of it where it is in order.
     * @returns {Promise<boolean>} whether it is in order
     */
    check() {
        return new Promise((resolve) => {
            // One that is given up for the next has no answer of its own.
            this.given_up?.(false);
            this.given_up = resolve;
            const done = (/** @type {boolean} */ good) => {
                if (this.given_up === resolve) this.given_up = null;
                resolve(good);
            };
            const question = { model: { ...this.store.model(false), set: [], initial: [] } };
            this.latest.run(async (signal) => {
                try {
                    for await (const message of this.ask("check", question, signal)) {
                        if (message.kind !== DOCUMENT) continue;
                        this.store.checked = document_of(message);
                    }
                    this.problems = [];
                    this.mark();
                    this.tell();
                    done(true);
                    this.store.change("model", () => {});
                } catch (error) {
                    if (is_abort(error)) {
                        done(false);
                        return;
                    }
                    const refusal = error instanceof Refused ? error.refusal : { message: String(error) };
                    this.problems = refusal.errors ?? [{ ...refusal, line: 0 }];
                    this.mark();
                    this.tell();
                    done(false);
                }
            });
        });
    }

    /** Colours the text and underlines what is wrong. */
    mark() {
        const { value } = this.area;
        const spans = this.problems
            .filter(({ from }) => from !== null && from !== undefined)
            .map(({ from, to }) => ({ from: /** @type {number} */ (from), to: Math.max(/** @type {number} */ (from) + 1, /** @type {number} */ (to)) }));
        /** @type {Node[]} */
        const nodes = [];
        for (const { from, to, name } of tokens(value)) {
            let at = from;
            while (at < to) {
                const inside = spans.some((span) => span.from <= at && at < span.to);
                const edges = spans.flatMap((span) => [span.from, span.to]).filter((edge) => edge > at && edge < to);
                const end = edges.length ? Math.min(...edges) : to;
                const part = value.slice(at, end);
                const classes = [name, inside ? "wrong" : ""].filter(Boolean).join(" ");
                nodes.push(classes ? make("span", { class: classes }, part) : document.createTextNode(part));
                at = end;
            }
        }
        // What is missing at the very end still has a place.
        if (spans.some(({ from }) => from >= value.length)) nodes.push(make("span", { class: "wrong" }, " "));
        nodes.push(document.createTextNode("\n"));
        this.backdrop.replaceChildren(...nodes);
        const lines = value.split("\n").length;
        const wrong = new Set(this.problems.map(({ line }) => line));
        this.gutter.replaceChildren(...Array.from({ length: lines }, (_, index) => make("span", { class: wrong.has(index + 1) ? "bad" : "" }, `${index + 1}\n`)));
        this.area.setAttribute("aria-invalid", String(this.problems.length > 0));
        this.scroll();
    }

    tell() {
        const warnings = this.problems.length === 0 ? (this.store.checked?.warnings ?? []) : [];
        this.list.replaceChildren(
            ...this.problems.map((problem) => make("li", { class: "problem" }, make("button", { type: "button", onclick: () => this.go(problem) },
                problem.line ? make("b", {}, `line ${problem.line}, column ${problem.column}`) : "", make("span", {}, problem.message),
                problem.help ? make("small", {}, problem.help) : ""))),
            ...warnings.map((warning) => make("li", { class: "warning" }, warning)),
        );
    }

    /** @param {Problem} problem */
    go(problem) {
        if (problem.from === null || problem.from === undefined) return;
        this.area.focus();
        this.area.setSelectionRange(problem.from, problem.to ?? problem.from);
        const height = parseFloat(getComputedStyle(this.area).lineHeight);
        this.area.scrollTop = Math.max(0, (problem.line - 4) * height);
    }

    scroll() {
        const { scrollTop, scrollLeft } = this.area;
        this.backdrop.style.transform = `translate(${-scrollLeft}px, ${-scrollTop}px)`;
        this.gutter.style.transform = `translateY(${-scrollTop}px)`;
    }
}

/**
 * The words of TOML that have colours of their own.
 * @param {string} text
 */
function* tokens(text) {
    const pattern = /(?<comment>#[^\n]*)|(?<string>"(?:[^"\\\n]|\\.)*"|'[^'\n]*')|(?<table>^[ \t]*\[\[?[^\]\n]*\]\]?)|(?<key>^[ \t]*[\w.-]+(?=[ \t]*=))|(?<number>\b-?\d[\d.eE_]*\b)/gm;
    let at = 0;
    for (const match of text.matchAll(pattern)) {
        if (match.index > at) yield { from: at, to: match.index, name: "" };
        const [name] = Object.entries(match.groups ?? {}).find(([, found]) => found !== undefined) ?? [""];
        yield { from: match.index, to: match.index + match[0].length, name };
        at = match.index + match[0].length;
    }
    if (at < text.length) yield { from: at, to: text.length, name: "" };
}
