/** Asks questions: here of the server that the page comes from. */

import { DOCUMENT, END, NUMBERS, PROGRESS, REFUSAL, Reader, document_of, numbers, text } from "./records.js";

/** @typedef {import("./records.js").Message} Message */
/** @typedef {(asked: string, question: object, signal: AbortSignal) => AsyncIterable<Message>} Ask */

/** Why there is no answer, as the command line would say it. */
export class Refused extends Error {
    /** @param {any} refusal */
    constructor(refusal) {
        super(refusal.message);
        this.refusal = refusal;
    }
}

/**
 * Over HTTP. Aborting the signal hangs up, which stops the work.
 * @type {Ask}
 */
export async function* over_http(asked, question, signal) {
    const reply = await fetch(asked, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify(question),
        signal,
    });
    if (!reply.ok || !reply.body) throw new Refused(await reply.json());
    const reader = new Reader();
    const stream = reply.body.getReader();
    try {
        for (;;) {
            const { done, value } = await stream.read();
            if (done) throw new Refused({ kind: "output", message: "the connection broke off" });
            for (const message of reader.take(value)) {
                if (message.kind === END) return;
                if (message.kind === REFUSAL) throw new Refused(document_of(message));
                yield message;
            }
        }
    } finally {
        stream.cancel().catch(() => {});
    }
}

/**
 * The documents and columns of numbers of an answer.
 * @param {AsyncIterable<Message>} answer
 * @param {(message: string) => void} [progress]
 */
export async function collected(answer, progress) {
    /** @type {any[]} */
    const documents = [];
    /** @type {Float64Array[]} */
    const columns = [];
    for await (const message of answer) {
        if (message.kind === DOCUMENT) documents.push(document_of(message));
        if (message.kind === NUMBERS) columns.push(numbers(message));
        if (message.kind === PROGRESS) progress?.(text(message));
    }
    return { documents, columns };
}

/** @param {unknown} error */
export const is_abort = (error) => error instanceof DOMException && error.name === "AbortError";

/**
 * One question at a time, the latest: what is asked while another is answered waits for a moment, so that views follow a
 * slider, and ends it where it takes long.
 */
export class Latest {
    /** @param {number} patience in milliseconds */
    constructor(patience) {
        this.patience = patience;
        /** @type {AbortController | null} */
        this.running = null;
        /** @type {((signal: AbortSignal) => Promise<void>) | null} */
        this.waiting = null;
        this.began = 0;
        this.timer = 0;
    }

    /** @param {(signal: AbortSignal) => Promise<void>} work */
    run(work) {
        this.waiting = work;
        if (!this.running) {
            this.next();
            return;
        }
        window.clearTimeout(this.timer);
        const left = this.began + this.patience - performance.now();
        this.timer = window.setTimeout(() => this.running?.abort(), Math.max(0, left));
    }

    stop() {
        this.waiting = null;
        this.running?.abort();
    }

    next() {
        window.clearTimeout(this.timer);
        const work = this.waiting;
        this.waiting = null;
        if (!work) return;
        const controller = new AbortController();
        this.running = controller;
        this.began = performance.now();
        work(controller.signal)
            .catch((error) => {
                if (!is_abort(error)) console.error(error);
            })
            .finally(() => {
                this.running = null;
                this.next();
            });
    }
}
