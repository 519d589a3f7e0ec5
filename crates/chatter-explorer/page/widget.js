/** The explorer in a notebook: asks the kernel by messages, and keeps its address in the widget's state. */

import { explore } from "./explorer.js";
import { END, REFUSAL, Reader, document_of } from "./asking/records.js";
import { Refused } from "./asking/transport.js";

/**
 * @typedef {object} Widget as anywidget gives it
 * @property {(name: string) => any} get
 * @property {(name: string, value: any) => void} set
 * @property {() => void} save_changes
 * @property {(event: string, listener: (...given: any[]) => void) => void} on
 * @property {(event: string, listener: (...given: any[]) => void) => void} off
 * @property {(content: object) => void} send
 */

let numbers = 0;

/**
 * @param {Widget} widget
 * @returns {import("./asking/transport.js").Ask}
 */
export function over_messages(widget) {
    return async function* (asked, question, signal) {
        numbers += 1;
        const number = numbers;
        const reader = new Reader();
        /** @type {import("./asking/records.js").Message[]} */
        const messages = [];
        let wake = () => {};
        const heard = (/** @type {any} */ content, /** @type {DataView[]} */ buffers) => {
            if (content.number !== number) return;
            for (const buffer of buffers) messages.push(...reader.take(new Uint8Array(buffer.buffer, buffer.byteOffset, buffer.byteLength)));
            wake();
        };
        const aborted = () => wake();
        widget.on("msg:custom", heard);
        signal.addEventListener("abort", aborted);
        widget.send({ number, asked, question });
        let done = false;
        try {
            for (;;) {
                if (signal.aborted) throw new DOMException("broken off", "AbortError");
                const message = messages.shift();
                if (!message) {
                    await new Promise((resolve) => (wake = () => resolve(undefined)));
                    continue;
                }
                if (message.kind === END) {
                    done = true;
                    return;
                }
                if (message.kind === REFUSAL) throw new Refused(document_of(message));
                yield message;
            }
        } finally {
            widget.off("msg:custom", heard);
            signal.removeEventListener("abort", aborted);
            if (!done) widget.send({ number, stop: true });
        }
    };
}

/**
 * @param {Widget} widget
 * @returns {import("./explorer.js").Place}
 */
const in_widget = (widget) => ({
    read: () => widget.get("address"),
    write: (address) => {
        widget.set("address", address);
        widget.save_changes();
    },
    on: (listener) => widget.on("change:address", listener),
});

export default {
    /** @param {{ model: Widget, el: HTMLElement }} given */
    async render({ model, el }) {
        const root = document.createElement("div");
        root.className = "chatter-explorer";
        el.append(root);
        await explore(root, over_messages(model), in_widget(model));
    },
};
